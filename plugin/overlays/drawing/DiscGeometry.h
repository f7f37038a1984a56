#pragma once

#include <osgMidair/Overlay>

#include <osg/Geometry>
#include <osg/Image>
#include <osg/Program>
#include <osg/Texture2D>
#include <osg/Vec3>

#include <Eigen/Core>

#include <array>

namespace osgMidair
{

/// Makes an empty geometry for changing positions and colours, drawn as \a primitives.
osg::ref_ptr<osg::Geometry> makeChanging(osg::PrimitiveSet* primitives);

/// Marks arrays and primitives of a geometry from makeChanging() as changed.
void showChanges(osg::Geometry& geometry);

/// \{ The arrays of such a geometry; discs have normals, too.
osg::Vec3Array& verticesOf(osg::Geometry& geometry);
osg::Vec3Array& normalsOf(osg::Geometry& geometry);
osg::Vec4ubArray& colorsOf(osg::Geometry& geometry);
/// \}

/// Makes a geometry for many small discs. Each is a triangle around the disc, which a shader cuts
/// out: half as many triangles as with quads, and software OpenGL spends its time on triangles. The
/// caller sets vertices and normals, three for each disc. Texture coordinates are the corners in
/// units of the disc's radius, kDiscCorners.
osg::ref_ptr<osg::Geometry> makeDiscs();
constexpr std::array<std::array<float, 2>, 3> kDiscCorners = {
    {{0.0F, 2.0F}, {-1.7320508F, -1.0F}, {1.7320508F, -1.0F}}};

/// Sets the number of discs of \a geometry; new ones are at the origin, white.
void resizeDiscs(osg::Geometry& geometry, int count);

/// Sets all values of disc \a disc in a geometry from makeDiscs(), with its corners at one place:
/// the shader moves them apart.
void setDisc(osg::Geometry& geometry,
             int disc,
             const osg::Vec3& place,
             const osg::Vec4ub& color,
             const osg::Vec3& normal = osg::Vec3(0.0F, 0.0F, 1.0F));

/// Makes a texture of \a image (null: without one), with or without interpolation between texels.
osg::ref_ptr<osg::Texture2D> makeTexture(osg::Image* image, bool smooth);

/// Makes a program from sources in GLSL 1.20, which runs wherever OSG does.
osg::ref_ptr<osg::Program>
makeProgram(const char* name, const char* vertexSource, const char* fragmentSource);

/// Converts colour and opacity (0 .. 1) to bytes.
osg::Vec4ub bytes(const osg::Vec3f& color, float opacity);

/// Draws \a node after opaque nodes, in the order of \a bin, blended, with depth test but without
/// writing depth.
void drawTranslucent(osg::Node& node, int bin);

/// Converts a position or direction to floats.
inline osg::Vec3 osgVec(const Eigen::Vector3d& v)
{
    return osg::Vec3(
        static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()));
}

} // namespace osgMidair
