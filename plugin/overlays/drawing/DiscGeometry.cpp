#include "plugin/overlays/drawing/DiscGeometry.h"

#include <osg/BlendFunc>
#include <osg/Depth>

#include <algorithm>
#include <cmath>

namespace osgMidair
{

osg::ref_ptr<osg::Geometry> makeChanging(osg::PrimitiveSet* primitives)
{
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    geometry->setDataVariance(osg::Object::DYNAMIC);
    geometry->setUseDisplayList(false);
    geometry->setUseVertexBufferObjects(true);
    geometry->setVertexArray(new osg::Vec3Array);
    geometry->setColorArray(new osg::Vec4ubArray, osg::Array::BIND_PER_VERTEX);
    geometry->getColorArray()->setNormalize(true);
    geometry->addPrimitiveSet(primitives);
    return geometry;
}

void showChanges(osg::Geometry& geometry)
{
    osg::Geometry::ArrayList arrays;
    geometry.getArrayList(arrays);
    for (const osg::ref_ptr<osg::Array>& array : arrays)
        array->dirty();
    osg::PrimitiveSet& primitives = *geometry.getPrimitiveSet(0);
    if (auto* all = dynamic_cast<osg::DrawArrays*>(&primitives))
        all->setCount(static_cast<GLsizei>(geometry.getVertexArray()->getNumElements()));
    primitives.dirty();
    geometry.dirtyBound();
}

osg::ref_ptr<osg::Geometry> makeDiscs()
{
    osg::ref_ptr<osg::Geometry> geometry = makeChanging(new osg::DrawElementsUInt(GL_TRIANGLES));
    geometry->setNormalArray(new osg::Vec3Array, osg::Array::BIND_PER_VERTEX);
    geometry->setTexCoordArray(0, new osg::Vec2Array, osg::Array::BIND_PER_VERTEX);
    return geometry;
}

void resizeDiscs(osg::Geometry& geometry, int count)
{
    const auto corners = static_cast<std::size_t>(count) * kDiscCorners.size();
    osg::Vec3Array& vertices = verticesOf(geometry);
    if (vertices.size() == corners) return;
    vertices.resize(corners);
    normalsOf(geometry).resize(corners, osg::Vec3(0.0F, 0.0F, 1.0F));
    colorsOf(geometry).resize(corners, osg::Vec4ub(255, 255, 255, 255));
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

osg::Vec3Array& verticesOf(osg::Geometry& geometry)
{
    return static_cast<osg::Vec3Array&>(*geometry.getVertexArray());
}

osg::Vec3Array& normalsOf(osg::Geometry& geometry)
{
    return static_cast<osg::Vec3Array&>(*geometry.getNormalArray());
}

osg::Vec4ubArray& colorsOf(osg::Geometry& geometry)
{
    return static_cast<osg::Vec4ubArray&>(*geometry.getColorArray());
}

void setDisc(osg::Geometry& geometry,
             int disc,
             const osg::Vec3& place,
             const osg::Vec4ub& color,
             const osg::Vec3& normal)
{
    const std::size_t first = kDiscCorners.size() * static_cast<std::size_t>(disc);
    for (std::size_t corner = first; corner < first + kDiscCorners.size(); ++corner)
    {
        verticesOf(geometry)[corner] = place;
        normalsOf(geometry)[corner] = normal;
        colorsOf(geometry)[corner] = color;
    }
}

osg::ref_ptr<osg::Texture2D> makeTexture(osg::Image* image, bool smooth)
{
    osg::ref_ptr<osg::Texture2D> texture = new osg::Texture2D(image);
    if (image) texture->setDataVariance(image->getDataVariance());
    texture->setResizeNonPowerOfTwoHint(false);
    const auto filter = smooth ? osg::Texture::LINEAR : osg::Texture::NEAREST;
    texture->setFilter(osg::Texture::MIN_FILTER, filter);
    texture->setFilter(osg::Texture::MAG_FILTER, filter);
    texture->setWrap(osg::Texture::WRAP_S, osg::Texture::CLAMP_TO_EDGE);
    texture->setWrap(osg::Texture::WRAP_T, osg::Texture::CLAMP_TO_EDGE);
    return texture;
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
