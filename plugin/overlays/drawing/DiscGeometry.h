#pragma once

#include <osgMidair/Overlay>

#include <osg/Geometry>
#include <osg/Program>
#include <osg/Vec3>

#include <Eigen/Core>

#include <array>

namespace osgMidair
{

/// Makes a geometry for many small discs. Each is a triangle around the disc, which a shader cuts
/// out: half as many triangles as with quads, and software OpenGL spends its time on triangles. The
/// caller sets vertices and normals, three for each disc. Texture coordinates are the corners in
/// units of the disc's radius, kDiscCorners.
osg::ref_ptr<osg::Geometry> makeDiscs();
constexpr std::array<std::array<float, 2>, 3> kDiscCorners = {
    {{0.0F, 2.0F}, {-1.7320508F, -1.0F}, {1.7320508F, -1.0F}}};

/// Sets the number of discs of \a geometry; new ones are at the origin, white.
void resizeDiscs(osg::Geometry& geometry, int count);

/// The arrays of a geometry from makeDiscs().
osg::Vec3Array& discVertices(osg::Geometry& geometry);
osg::Vec3Array& discNormals(osg::Geometry& geometry);
osg::Vec4ubArray& discColors(osg::Geometry& geometry);

/// Makes a program from sources in GLSL 1.20, which runs wherever OSG does.
osg::ref_ptr<osg::Program>
makeProgram(const char* name, const char* vertexSource, const char* fragmentSource);

/// Converts colour and opacity (0 .. 1) to bytes.
osg::Vec4ub bytes(const osg::Vec3f& color, float opacity);

/// Draws \a node after opaque nodes, in the order of \a bin, blended, with depth test but without
/// writing depth.
void drawTranslucent(osg::Node& node, int bin);

/// A place or direction as graphics cards take it.
inline osg::Vec3 osgVec(const Eigen::Vector3d& v)
{
    return osg::Vec3(
        static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()));
}

} // namespace osgMidair
