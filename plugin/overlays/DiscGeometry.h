#pragma once

#include <osgMidair/Export>

#include <osg/Geometry>
#include <osg/Program>

#include <array>

namespace osgMidair
{

/// Many small discs in one geometry, each a triangle round the disc that a shader cuts out: half as
/// many triangles as quads have, and triangles are what software OpenGL spends its time on.
/// Vertices and normals are left to the caller, three a disc; the texture coordinate is where a
/// corner is if the disc has radius 1, one of kDiscCorners.
osg::ref_ptr<osg::Geometry> makeDiscs();
constexpr std::array<std::array<float, 2>, 3> kDiscCorners = {
    {{0.0F, 2.0F}, {-1.7320508F, -1.0F}, {1.7320508F, -1.0F}}};

/// Sets the number of discs of \a geometry; new ones are at the origin, white.
void resizeDiscs(osg::Geometry& geometry, int count);

/// Arrays of a geometry from makeDiscs.
osg::Vec3Array& discVertices(osg::Geometry& geometry);
osg::Vec3Array& discNormals(osg::Geometry& geometry);
osg::Vec4ubArray& discColors(osg::Geometry& geometry);

/// GLSL 1.20, so that it runs on whatever OSG itself runs on.
osg::ref_ptr<osg::Program>
makeProgram(const char* name, const char* vertexSource, const char* fragmentSource);

/// Colour and opacity in 0 .. 1 as bytes.
osg::Vec4ub bytes(const osg::Vec3f& color, float opacity);

/// Rendered after what is opaque, in the order of \a bin; tested against depth but leaving none;
/// blended.
OSGMIDAIR_EXPORT void drawTranslucent(osg::Node& node, int bin);

/// Bins: later ones are painted over earlier ones.
enum OverlayBin
{
    GHOST_BIN = 11,
    BOX_BIN = 12,
    SLICE_BIN = 13,
    VOLUME_BIN = 14,
    TRANSLUCENT_OBJECT_BIN = 15, ///< what an application draws over the field
    HAND_BIN = 16,
    POINT_BIN = 17,
    HUD_BIN = 100
};

} // namespace osgMidair
