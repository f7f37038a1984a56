#include "plugin/gltf/GltfMeshes.h"

#include "plugin/gltf/GltfMessages.h"

#include <osg/Material>
#include <osgUtil/SmoothingVisitor>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

constexpr std::size_t kMostMorphs = 256;

/// -1: the primitive has no such attribute.
int attributeOf(const std::map<std::string, int>& attributes, const std::string& name)
{
    const auto found = attributes.find(name);
    return found == attributes.end() ? -1 : found->second;
}

template<class Vectors>
osg::ref_ptr<Vectors> vectorsOf(const std::vector<float>& numbers)
{
    constexpr std::size_t kWidth = Vectors::ElementDataType::num_components;
    const osg::ref_ptr<Vectors> vectors = new Vectors(
        osg::Array::BIND_PER_VERTEX, static_cast<unsigned int>(numbers.size() / kWidth));
    for (std::size_t i = 0; i < vectors->size(); ++i)
        for (std::size_t k = 0; k < kWidth; ++k)
            (*vectors)[i][static_cast<int>(k)] = numbers[i * kWidth + k];
    return vectors;
}

GLenum modeOf(int mode)
{
    if (mode < 0) return GL_TRIANGLES;
    if (mode > TINYGLTF_MODE_TRIANGLE_FAN)
        throw GltfError(fmt::format("mode {} is not known", mode));
    return static_cast<GLenum>(mode); // they are OpenGL's
}

bool isTriangles(GLenum mode)
{
    return mode == GL_TRIANGLES || mode == GL_TRIANGLE_STRIP || mode == GL_TRIANGLE_FAN;
}

void require(bool isRight, const char* what)
{
    if (!isRight) throw GltfError(what);
}

} // namespace

std::vector<GltfPart> GltfMeshes::read(int number, const std::vector<double>& weights)
{
    if (number < 0 || static_cast<std::size_t>(number) >= _from.model.meshes.size())
        throw GltfError(fmt::format("there is no mesh {}", number));
    const tinygltf::Mesh& mesh = _from.model.meshes[static_cast<std::size_t>(number)];
    std::vector<GltfPart> parts;
    for (std::size_t i = 0; i < mesh.primitives.size(); ++i)
        try
        {
            parts.push_back(
                readPart(mesh.name, mesh.primitives[i], weights.empty() ? mesh.weights : weights));
        }
        catch (const GltfError& error)
        {
            _from.messages.say(fmt::format("primitive {} of mesh {} \"{}\" is left out: {}",
                                           i,
                                           number,
                                           mesh.name,
                                           error.what()));
        }
    return parts;
}

GltfPart GltfMeshes::readPart(const std::string& name,
                              const tinygltf::Primitive& primitive,
                              const std::vector<double>& weights)
{
    require(primitive.extensions.count("KHR_draco_mesh_compression") == 0, "it is compressed");
    GltfPart part;
    part.geometry = new osg::Geometry;
    osg::Geometry& geometry = *part.geometry;
    const auto vertices = vectorsOf<osg::Vec3Array>(
        _from.numbers.floats(attributeOf(primitive.attributes, "POSITION"), 3));
    const std::size_t count = vertices->size();
    require(count > 0, "it has no vertices");
    addMorphs(primitive, weights, *vertices);
    geometry.setName(name);
    geometry.setUseDisplayList(false);
    geometry.setUseVertexBufferObjects(true);
    geometry.setVertexArray(vertices);
    addIndices(primitive, count, geometry);
    addColors(primitive, count, geometry);
    addSkin(primitive, count, part);
    addCoordinates(primitive, count, geometry);
    if (const osg::ref_ptr<osg::StateSet> state = _materials.get(primitive.material))
        geometry.setStateSet(state);
    const int normals = attributeOf(primitive.attributes, "NORMAL");
    if (normals >= 0)
    {
        const auto given = vectorsOf<osg::Vec3Array>(_from.numbers.floats(normals, 3));
        require(given->size() == count, "it has not as many normals as vertices");
        geometry.setNormalArray(given, osg::Array::BIND_PER_VERTEX);
    }
    else if (isTriangles(geometry.getPrimitiveSet(0)->getMode()))
        osgUtil::SmoothingVisitor::smooth(geometry);
    return part;
}

void GltfMeshes::addCoordinates(const tinygltf::Primitive& primitive,
                                std::size_t count,
                                osg::Geometry& geometry)
{
    const GltfCoordinates way = _materials.coordinatesOf(primitive.material);
    if (way.set < 0) return;
    const int places = attributeOf(primitive.attributes, "TEXCOORD_" + std::to_string(way.set));
    if (places < 0)
    {
        _from.messages.sayOfPicture(
            fmt::format("mesh \"{}\" has a texture, and no TEXCOORD_{} that says where",
                        geometry.getName(),
                        way.set));
        return;
    }
    const auto coordinates = vectorsOf<osg::Vec2Array>(_from.numbers.floats(places, 2));
    require(coordinates->size() == count, "it has not as many texture coordinates as vertices");
    for (osg::Vec2& one : *coordinates)
        one = way.inImage(one);
    geometry.setTexCoordArray(0, coordinates, osg::Array::BIND_PER_VERTEX);
}

// A mesh is felt as it is at rest: its weights are those that the file gives it.
void GltfMeshes::addMorphs(const tinygltf::Primitive& primitive,
                           const std::vector<double>& weights,
                           osg::Vec3Array& vertices)
{
    if (primitive.targets.empty()) return;
    _from.messages.say("its morph targets stay as they are at rest");
    require(primitive.targets.size() <= kMostMorphs, "it has more than 256 morph targets");
    for (std::size_t k = 0; k < std::min(primitive.targets.size(), weights.size()); ++k)
    {
        const int moved = attributeOf(primitive.targets[k], "POSITION");
        const auto weight = static_cast<float>(weights[k]);
        if (moved < 0 || weight == 0.0F) continue;
        const auto by = vectorsOf<osg::Vec3Array>(_from.numbers.floats(moved, 3));
        require(by->size() == vertices.size(), "a morph target has not as many vertices");
        for (std::size_t i = 0; i < vertices.size(); ++i)
            vertices[i] += (*by)[i] * weight;
    }
    for (const osg::Vec3& vertex : vertices)
        require(std::isfinite(vertex.length2()), "its morph targets lead to no place");
}

void GltfMeshes::addIndices(const tinygltf::Primitive& primitive,
                            std::size_t count,
                            osg::Geometry& geometry)
{
    const GLenum mode = modeOf(primitive.mode);
    if (primitive.indices < 0)
    {
        geometry.addPrimitiveSet(new osg::DrawArrays(mode, 0, static_cast<GLsizei>(count)));
        return;
    }
    const std::vector<std::uint32_t> indices = _from.numbers.whole(primitive.indices, 1);
    const osg::ref_ptr<osg::DrawElementsUInt> elements = new osg::DrawElementsUInt(mode);
    elements->reserve(indices.size());
    for (const std::uint32_t index : indices)
    {
        if (index >= count)
            throw GltfError(fmt::format("index {} is of none of its {} vertices", index, count));
        elements->push_back(index);
    }
    require(!indices.empty(), "it has no indices");
    geometry.addPrimitiveSet(elements);
}

void GltfMeshes::addColors(const tinygltf::Primitive& primitive,
                           std::size_t count,
                           osg::Geometry& geometry)
{
    const int number = attributeOf(primitive.attributes, "COLOR_0");
    if (number < 0)
    {
        const osg::ref_ptr<osg::StateSet> state = _materials.get(primitive.material);
        const auto* material = dynamic_cast<const osg::Material*>(
            state ? state->getAttribute(osg::StateAttribute::MATERIAL) : nullptr);
        const osg::ref_ptr<osg::Vec4Array> one = new osg::Vec4Array(osg::Array::BIND_OVERALL);
        one->push_back(material ? material->getDiffuse(osg::Material::FRONT)
                                : osg::Vec4(1, 1, 1, 1));
        geometry.setColorArray(one, osg::Array::BIND_OVERALL);
        return;
    }
    const int width = _from.numbers.componentsOf(number);
    require(width == 3 || width == 4, "colours should have three or four components");
    const std::vector<float> given = _from.numbers.floats(number, width);
    require(given.size() == count * static_cast<std::size_t>(width),
            "it has not as many colours as vertices");
    const osg::ref_ptr<osg::Vec4Array> colors =
        new osg::Vec4Array(osg::Array::BIND_PER_VERTEX, static_cast<unsigned int>(count));
    for (std::size_t i = 0; i < count; ++i)
    {
        (*colors)[i].a() = 1.0F;
        for (int k = 0; k < width; ++k)
            (*colors)[i][k] =
                std::clamp(given[i * static_cast<std::size_t>(width) + static_cast<std::size_t>(k)],
                           0.0F,
                           1.0F);
    }
    geometry.setColorArray(colors, osg::Array::BIND_PER_VERTEX);
}

void GltfMeshes::addSkin(const tinygltf::Primitive& primitive, std::size_t count, GltfPart& part)
{
    const int joints = attributeOf(primitive.attributes, "JOINTS_0");
    const int weights = attributeOf(primitive.attributes, "WEIGHTS_0");
    if (joints < 0 || weights < 0) return;
    if (attributeOf(primitive.attributes, "JOINTS_1") >= 0)
        _from.messages.say("of its vertices' joints the first four move them");
    part.joints = _from.numbers.whole(joints, 4);
    part.weights = _from.numbers.floats(weights, 4);
    require(part.joints.size() == 4 * count && part.weights.size() == 4 * count,
            "it has not as many joints and weights as vertices");
}

} // namespace osgMidair
