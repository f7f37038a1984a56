#include "plugin/overlays/drawing/DiscGeometry.h"

#include <osg/BlendFunc>
#include <osg/Depth>

#include <algorithm>
#include <cmath>

namespace osgMidair
{

osg::ref_ptr<osg::Geometry> makeDiscs()
{
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    geometry->setDataVariance(osg::Object::DYNAMIC);
    geometry->setUseDisplayList(false);
    geometry->setUseVertexBufferObjects(true);
    geometry->setVertexArray(new osg::Vec3Array);
    geometry->setNormalArray(new osg::Vec3Array, osg::Array::BIND_PER_VERTEX);
    osg::ref_ptr<osg::Vec4ubArray> colors = new osg::Vec4ubArray;
    colors->setNormalize(true);
    geometry->setColorArray(colors, osg::Array::BIND_PER_VERTEX);
    geometry->setTexCoordArray(0, new osg::Vec2Array, osg::Array::BIND_PER_VERTEX);
    geometry->addPrimitiveSet(new osg::DrawElementsUInt(GL_TRIANGLES));
    return geometry;
}

void resizeDiscs(osg::Geometry& geometry, int count)
{
    const auto corners = static_cast<std::size_t>(count) * kDiscCorners.size();
    osg::Vec3Array& vertices = discVertices(geometry);
    if (vertices.size() == corners) return;
    vertices.resize(corners);
    discNormals(geometry).resize(corners, osg::Vec3(0.0F, 0.0F, 1.0F));
    discColors(geometry).resize(corners, osg::Vec4ub(255, 255, 255, 255));
    auto& coordinates = static_cast<osg::Vec2Array&>(*geometry.getTexCoordArray(0));
    auto& indices = static_cast<osg::DrawElementsUInt&>(*geometry.getPrimitiveSet(0));
    coordinates.clear();
    indices.clear();
    for (std::size_t corner = 0; corner < corners; ++corner)
    {
        const auto& at = kDiscCorners[corner % kDiscCorners.size()];
        coordinates.push_back(osg::Vec2(at[0], at[1]));
        indices.push_back(static_cast<unsigned int>(corner));
    }
    coordinates.dirty();
    indices.dirty();
}

osg::Vec3Array& discVertices(osg::Geometry& geometry)
{
    return static_cast<osg::Vec3Array&>(*geometry.getVertexArray());
}

osg::Vec3Array& discNormals(osg::Geometry& geometry)
{
    return static_cast<osg::Vec3Array&>(*geometry.getNormalArray());
}

osg::Vec4ubArray& discColors(osg::Geometry& geometry)
{
    return static_cast<osg::Vec4ubArray&>(*geometry.getColorArray());
}

osg::ref_ptr<osg::Program>
makeProgram(const char* name, const char* vertexSource, const char* fragmentSource)
{
    osg::ref_ptr<osg::Program> program = new osg::Program;
    program->setName(name);
    program->addShader(new osg::Shader(osg::Shader::VERTEX, vertexSource));
    program->addShader(new osg::Shader(osg::Shader::FRAGMENT, fragmentSource));
    return program;
}

osg::Vec4ub bytes(const osg::Vec3f& color, float opacity)
{
    const auto byte = [](float v)
    { return static_cast<unsigned char>(std::lround(255.0F * std::clamp(v, 0.0F, 1.0F))); };
    return {byte(color.x()), byte(color.y()), byte(color.z()), byte(opacity)};
}

void drawTranslucent(osg::Node& node, int bin)
{
    osg::StateSet* state = node.getOrCreateStateSet();
    state->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
    state->setMode(GL_CULL_FACE, osg::StateAttribute::OFF);
    state->setAttributeAndModes(new osg::BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA));
    state->setAttributeAndModes(new osg::Depth(osg::Depth::LEQUAL, 0.0, 1.0, false));
    state->setRenderBinDetails(bin, "DepthSortedBin");
}

} // namespace osgMidair
