#pragma once

#include <osgMidair/Export>

#include <osg/Geometry>
#include <osg/Program>

namespace osgMidair
{

/// Many small quads in one geometry for a shader that rounds them off: per quad one colour, per corner a texture coordinate in
/// -1 .. 1 that says which corner it is. Vertices and normals are left to the caller, four a quad.
osg::ref_ptr<osg::Geometry> makeQuads();

/// Sets the number of quads of \a geometry; new ones are at the origin, white.
void resizeQuads(osg::Geometry& geometry, int count);

/// Arrays of a geometry from makeQuads.
osg::Vec3Array& quadVertices(osg::Geometry& geometry);
osg::Vec3Array& quadNormals(osg::Geometry& geometry);
osg::Vec4ubArray& quadColors(osg::Geometry& geometry);

/// GLSL 1.20, so that it runs on whatever OSG itself runs on.
osg::ref_ptr<osg::Program>
makeProgram(const char* name, const char* vertexSource, const char* fragmentSource);

/// Colour and opacity in 0 .. 1 as bytes.
osg::Vec4ub bytes(const osg::Vec3f& color, float opacity);

/// Rendered after what is opaque, in the order of \a bin; tested against depth but leaving none; blended.
OSGMIDAIR_EXPORT void drawTranslucent(osg::Node& node, int bin);

/// Bins: later ones are painted over earlier ones.
enum OverlayBin
{
    GHOST_BIN = 11,
    BOX_BIN = 12,
    SLICE_BIN = 13,
    TRANSLUCENT_OBJECT_BIN = 14, ///< what an application draws over the slice
    POINT_BIN = 15,
    HUD_BIN = 100
};

} // namespace osgMidair
