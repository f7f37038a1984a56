#include "plugin/gltf/GltfMeshes.h"

#include <osg/AlphaFunc>
#include <osg/Image>
#include <osg/Material>
#include <osg/StateSet>
#include <osg/Texture2D>
#include <osg/Vec2>
#include <osg/Vec2d>
#include <osgDB/Registry>
#include <osgUtil/SmoothingVisitor>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

/// Width and height from the header of a PNG or JPEG file, before decoding: a file of a few bytes
/// may announce gigabytes.
struct ImageSize
{
    std::size_t width = 0; ///< 0: neither PNG nor JPEG
    std::size_t height = 0;
    const char* extension = ""; ///< "png", "jpg"
};

std::size_t bigEndian(const unsigned char* bytes, int count)
{
    std::size_t value = 0;
    for (int i = 0; i < count; ++i)
        value = value << 8 | bytes[i];
    return value;
}

/// A JPEG file is a sequence of segments; one of them begins a frame and has its size.
ImageSize jpegSize(const unsigned char* bytes, std::size_t size)
{
    for (std::size_t at = 2; at + 9 <= size && bytes[at] == 0xFF;)
    {
        const unsigned char marker = bytes[at + 1];
        if (marker == 0xFF) // fill bytes
        {
            ++at;
            continue;
        }
        const bool isFrame =
            marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
        if (isFrame) return {bigEndian(bytes + at + 7, 2), bigEndian(bytes + at + 5, 2), "jpg"};
        at += 2 + bigEndian(bytes + at + 2, 2);
    }
    return {};
}

ImageSize imageSizeOf(const unsigned char* bytes, std::size_t size)
{
    if (size >= 24 && std::memcmp(bytes, "\x89PNG\r\n\x1A\n", 8) == 0 &&
        std::memcmp(bytes + 12, "IHDR", 4) == 0)
        return {bigEndian(bytes + 16, 4), bigEndian(bytes + 20, 4), "png"};
    if (size >= 4 && bytes[0] == 0xFF && bytes[1] == 0xD8) return jpegSize(bytes, size);
    return {};
}

osg::Texture::WrapMode wrapOf(int mode)
{
    return mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE     ? osg::Texture::CLAMP_TO_EDGE
           : mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? osg::Texture::MIRROR
                                                           : osg::Texture::REPEAT;
}

/// Returns member \a name of an extension as \a count numbers; \a otherwise if it is missing.
/// Throws GltfError.
std::vector<double>
numbersIn(const tinygltf::Value& extension, const char* name, std::vector<double> otherwise)
{
    if (!extension.IsObject() || !extension.Has(name)) return otherwise;
    const tinygltf::Value& value = extension.Get(name);
    const std::size_t count = otherwise.size();
    for (std::size_t i = 0; i < count; ++i)
    {
        const tinygltf::Value& one = value.IsArray() ? value.Get(static_cast<int>(i)) : value;
        otherwise[i] = one.IsNumber() ? one.GetNumberAsDouble() : HUGE_VAL;
    }
    const std::size_t given = value.IsArray() ? value.ArrayLen() : 1;
    if (given != count || std::any_of(otherwise.begin(),
                                      otherwise.end(),
                                      [](double x) { return !(std::abs(x) < 1e9); }))
        throw GltfError(std::string("its KHR_texture_transform has no right ") + name);
    return otherwise;
}

constexpr std::size_t kMostMorphs = 256;

/// Returns -1 if the primitive lacks the attribute.
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
    if (mode > TINYGLTF_MODE_TRIANGLE_FAN) failGltf("mode {} is unknown", mode);
    return static_cast<GLenum>(mode); // OpenGL's values
}

bool isTriangles(GLenum mode)
{
    return mode == GL_TRIANGLES || mode == GL_TRIANGLE_STRIP || mode == GL_TRIANGLE_FAN;
}

/// Decodes a model's PNG and JPEG images, each once, with OSG's plugins. Invalid images are left
/// out with a message.
class GltfImages
{
public:
    static constexpr std::size_t kMostPixels = std::size_t(64) << 20; ///< in total
    static constexpr std::size_t kLongestSide = 16384;

    explicit GltfImages(GltfReading& from) :
        _from(from),
        _isDecoded(from.model.images.size()),
        _images(from.model.images.size())
    {
    }

    /// Returns image \a number; null if there is none.
    osg::ref_ptr<osg::Image> get(int number)
    {
        if (!gltfEntry(_images, number)) return nullptr;
        const auto at = static_cast<std::size_t>(number);
        if (!_isDecoded[at])
        {
            _isDecoded[at] = true;
            _images[at] = decode(number);
        }
        return _images[at];
    }

private:
    osg::ref_ptr<osg::Image> decode(int number)
    {
        const tinygltf::Image& image = _from.model.images[static_cast<std::size_t>(number)];
        std::string why;
        try
        {
            std::size_t size = image.image.size();
            const unsigned char* bytes = image.image.data();
            if (image.bufferView >= 0) bytes = _from.numbers.bytesOf(image.bufferView, size);
            const ImageSize seen = imageSizeOf(bytes, size);
            const bool isSmall = seen.width > 0 && seen.height > 0 && seen.width <= kLongestSide &&
                                 seen.height <= kLongestSide && seen.width * seen.height <= _left;
            osgDB::ReaderWriter* reader = nullptr;
            if (size == 0)
                why = "its file can't be read";
            else if (seen.width == 0)
                why = "it is no PNG or JPEG";
            else if (!isSmall)
                why = fmt::format("{} x {} pixels are too many", seen.width, seen.height);
            else if (reader =
                         osgDB::Registry::instance()->getReaderWriterForExtension(seen.extension);
                     !reader)
                why = std::string("OSG has no plugin for ") + seen.extension;
            if (reader)
            {
                _left -= seen.width * seen.height;
                std::istringstream in(std::string(reinterpret_cast<const char*>(bytes), size));
                osgDB::ReaderWriter::ReadResult result = reader->readImage(in, nullptr);
                osg::ref_ptr<osg::Image> read = result.getImage();
                if (read && read->s() > 0)
                {
                    read->setName(image.name);
                    return read;
                }
                why = "it can't be decoded";
            }
        }
        catch (const GltfError& error)
        {
            why = error.what();
        }
        _from.messages.say(fmt::format("image {} \"{}\" is left out: {}", number, image.name, why));
        return nullptr;
    }

    GltfReading& _from;
    std::size_t _left = kMostPixels;
    std::vector<bool> _isDecoded;
    std::vector<osg::ref_ptr<osg::Image>> _images;
};

/// Maps a primitive's texture coordinates to its material's image.
struct GltfCoordinates
{
    int set = -1; ///< 0 for TEXCOORD_0; -1: there is no texture
    /// \{ KHR_texture_transform
    osg::Vec2d offset;
    osg::Vec2d scale = osg::Vec2d(1, 1);
    double rotation_rad = 0.0;
    /// \}

    /// Position in OSG's image, whose origin is at the bottom; glTF's is at the top. As in the
    /// extension's example a rotation by 90 degrees maps (u v) to (v -u).
    osg::Vec2 inImage(const osg::Vec2& coordinates) const
    {
        const double u = coordinates.x() * scale.x();
        const double v = coordinates.y() * scale.y();
        const double c = std::cos(rotation_rad);
        const double s = std::sin(rotation_rad);
        return osg::Vec2d(offset.x() + c * u + s * v, 1.0 - (offset.y() - s * u + c * v));
    }
};

/// Base colours and their textures; other parts of materials aren't drawn.
class GltfMaterials
{
public:
    explicit GltfMaterials(GltfReading& from) :
        _from(from),
        _images(from),
        _states(from.model.materials.size())
    {
    }

    /// Returns the state of material \a number; null if there is none.
    osg::ref_ptr<osg::StateSet> get(int number)
    {
        const tinygltf::Material* material = find(number);
        if (!material) return nullptr;
        osg::ref_ptr<osg::StateSet>& state = _states[static_cast<std::size_t>(number)];
        if (!state) state = make(*material);
        return state;
    }

    /// Returns the texture coordinates of its base colour. Throws GltfError.
    GltfCoordinates coordinatesOf(int number) const
    {
        GltfCoordinates way;
        const tinygltf::Material* material = find(number);
        if (!material || material->pbrMetallicRoughness.baseColorTexture.index < 0) return way;
        const tinygltf::TextureInfo& info = material->pbrMetallicRoughness.baseColorTexture;
        way.set = std::max(info.texCoord, 0);
        const auto found = info.extensions.find("KHR_texture_transform");
        if (found == info.extensions.end()) return way;
        const std::vector<double> offset = numbersIn(found->second, "offset", {0, 0});
        const std::vector<double> scale = numbersIn(found->second, "scale", {1, 1});
        way.offset.set(offset[0], offset[1]);
        way.scale.set(scale[0], scale[1]);
        way.rotation_rad = numbersIn(found->second, "rotation", {0})[0];
        way.set = static_cast<int>(
            std::max(0.0, numbersIn(found->second, "texCoord", {double(way.set)})[0]));
        return way;
    }

private:
    const tinygltf::Material* find(int number) const
    {
        return gltfEntry(_from.model.materials, number);
    }

    osg::ref_ptr<osg::StateSet> make(const tinygltf::Material& material)
    {
        const osg::ref_ptr<osg::StateSet> state = new osg::StateSet;
        const osg::ref_ptr<osg::Material> drawn = new osg::Material;
        osg::Vec4 color(1, 1, 1, 1);
        const std::vector<double>& factor = material.pbrMetallicRoughness.baseColorFactor;
        for (unsigned int i = 0; i < 4 && i < factor.size(); ++i)
            color[i] = static_cast<float>(std::clamp(factor[i], 0.0, 1.0));
        // Vertex colours replace the material's.
        drawn->setColorMode(osg::Material::AMBIENT_AND_DIFFUSE);
        drawn->setDiffuse(osg::Material::FRONT_AND_BACK, color);
        drawn->setAmbient(osg::Material::FRONT_AND_BACK, color);
        drawn->setName(material.name);
        state->setName(material.name);
        state->setAttributeAndModes(drawn);
        if (material.alphaMode == "BLEND")
        {
            state->setMode(GL_BLEND, osg::StateAttribute::ON);
            state->setRenderingHint(osg::StateSet::TRANSPARENT_BIN);
        }
        if (material.alphaMode == "MASK")
            state->setAttributeAndModes(
                new osg::AlphaFunc(osg::AlphaFunc::GEQUAL,
                                   static_cast<float>(std::clamp(material.alphaCutoff, 0.0, 1.0))));
        if (material.extensions.count("KHR_materials_unlit") > 0)
            state->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
        addTexture(material.pbrMetallicRoughness.baseColorTexture, *state);
        if (material.normalTexture.index >= 0 || material.emissiveTexture.index >= 0 ||
            material.occlusionTexture.index >= 0 ||
            material.pbrMetallicRoughness.metallicRoughnessTexture.index >= 0)
            _from.messages.sayOfPicture(
                "only the base colour of its materials is drawn, no other texture");
        return state;
    }

    void addTexture(const tinygltf::TextureInfo& info, osg::StateSet& state)
    {
        const tinygltf::Texture* texture = gltfEntry(_from.model.textures, info.index);
        const osg::ref_ptr<osg::Image> image = texture ? _images.get(texture->source) : nullptr;
        if (!image) return;
        const osg::ref_ptr<osg::Texture2D> drawn = new osg::Texture2D(image);
        drawn->setWrap(osg::Texture::WRAP_S, osg::Texture::REPEAT);
        drawn->setWrap(osg::Texture::WRAP_T, osg::Texture::REPEAT);
        if (const tinygltf::Sampler* sampler = gltfEntry(_from.model.samplers, texture->sampler))
        {
            drawn->setWrap(osg::Texture::WRAP_S, wrapOf(sampler->wrapS));
            drawn->setWrap(osg::Texture::WRAP_T, wrapOf(sampler->wrapT));
            if (sampler->magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST)
                drawn->setFilter(osg::Texture::MAG_FILTER, osg::Texture::NEAREST);
        }
        state.setTextureAttributeAndModes(0, drawn);
    }

    GltfReading& _from;
    GltfImages _images;
    std::vector<osg::ref_ptr<osg::StateSet>> _states;
};

/// Makes geometries of a model's meshes. Invalid primitives are left out with a message.
class GltfMeshes
{
public:
    explicit GltfMeshes(GltfReading& from) : _from(from), _materials(from) {}

    /// Reads the parts of mesh \a number anew, with the \a weights of its morph targets; empty: its
    /// own ones. Throws GltfError if there is no such mesh.
    std::vector<GltfPart> read(int number, const std::vector<double>& weights)
    {
        const tinygltf::Mesh* found = gltfEntry(_from.model.meshes, number);
        if (!found) failGltf("there is no mesh {}", number);
        const tinygltf::Mesh& mesh = *found;
        std::vector<GltfPart> parts;
        for (std::size_t i = 0; i < mesh.primitives.size(); ++i)
            try
            {
                parts.push_back(readPart(
                    mesh.name, mesh.primitives[i], weights.empty() ? mesh.weights : weights));
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

private:
    GltfPart readPart(const std::string& name,
                      const tinygltf::Primitive& primitive,
                      const std::vector<double>& weights)
    {
        requireGltf(primitive.extensions.count("KHR_draco_mesh_compression") == 0,
                    "it is compressed");
        GltfPart part;
        part.geometry = new osg::Geometry;
        osg::Geometry& geometry = *part.geometry;
        const auto vertices = vectorsOf<osg::Vec3Array>(
            _from.numbers.floats(attributeOf(primitive.attributes, "POSITION"), 3));
        const std::size_t count = vertices->size();
        requireGltf(count > 0, "it has no vertices");
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
            requireGltf(given->size() == count, "the numbers of normals and vertices differ");
            geometry.setNormalArray(given, osg::Array::BIND_PER_VERTEX);
        }
        else if (isTriangles(geometry.getPrimitiveSet(0)->getMode()))
            osgUtil::SmoothingVisitor::smooth(geometry);
        return part;
    }

    // A mesh is played at rest, with the weights in the file.
    void addMorphs(const tinygltf::Primitive& primitive,
                   const std::vector<double>& weights,
                   osg::Vec3Array& vertices)
    {
        if (primitive.targets.empty()) return;
        _from.messages.say("its morph targets keep their initial weights");
        requireGltf(primitive.targets.size() <= kMostMorphs, "it has more than 256 morph targets");
        for (std::size_t k = 0; k < std::min(primitive.targets.size(), weights.size()); ++k)
        {
            const int moved = attributeOf(primitive.targets[k], "POSITION");
            const auto weight = static_cast<float>(weights[k]);
            if (moved < 0 || weight == 0.0F) continue;
            const auto by = vectorsOf<osg::Vec3Array>(_from.numbers.floats(moved, 3));
            requireGltf(by->size() == vertices.size(),
                        "a morph target has another number of vertices");
            for (std::size_t i = 0; i < vertices.size(); ++i)
                vertices[i] += (*by)[i] * weight;
        }
        for (const osg::Vec3& vertex : vertices)
            requireGltf(std::isfinite(vertex.length2()),
                        "its morph targets give positions that are not finite");
    }

    void
    addCoordinates(const tinygltf::Primitive& primitive, std::size_t count, osg::Geometry& geometry)
    {
        const GltfCoordinates way = _materials.coordinatesOf(primitive.material);
        if (way.set < 0) return;
        const int places = attributeOf(primitive.attributes, "TEXCOORD_" + std::to_string(way.set));
        if (places < 0)
        {
            _from.messages.sayOfPicture(fmt::format(
                "mesh \"{}\" has a texture, but no TEXCOORD_{}", geometry.getName(), way.set));
            return;
        }
        const auto coordinates = vectorsOf<osg::Vec2Array>(_from.numbers.floats(places, 2));
        requireGltf(coordinates->size() == count,
                    "the numbers of texture coordinates and vertices differ");
        for (osg::Vec2& one : *coordinates)
            one = way.inImage(one);
        geometry.setTexCoordArray(0, coordinates, osg::Array::BIND_PER_VERTEX);
    }

    void addColors(const tinygltf::Primitive& primitive, std::size_t count, osg::Geometry& geometry)
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
        requireGltf(width == 3 || width == 4, "colours should have three or four components");
        const std::vector<float> given = _from.numbers.floats(number, width);
        requireGltf(given.size() == count * static_cast<std::size_t>(width),
                    "the numbers of colours and vertices differ");
        const osg::ref_ptr<osg::Vec4Array> colors =
            new osg::Vec4Array(osg::Array::BIND_PER_VERTEX, static_cast<unsigned int>(count));
        for (std::size_t i = 0; i < count; ++i)
        {
            (*colors)[i].a() = 1.0F;
            for (int k = 0; k < width; ++k)
                (*colors)[i][k] = std::clamp(
                    given[i * static_cast<std::size_t>(width) + static_cast<std::size_t>(k)],
                    0.0F,
                    1.0F);
        }
        geometry.setColorArray(colors, osg::Array::BIND_PER_VERTEX);
    }

    void
    addIndices(const tinygltf::Primitive& primitive, std::size_t count, osg::Geometry& geometry)
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
            if (index >= count) failGltf("index {} is beyond its {} vertices", index, count);
            elements->push_back(index);
        }
        requireGltf(!indices.empty(), "it has no indices");
        geometry.addPrimitiveSet(elements);
    }

    void addSkin(const tinygltf::Primitive& primitive, std::size_t count, GltfPart& part)
    {
        const int joints = attributeOf(primitive.attributes, "JOINTS_0");
        const int weights = attributeOf(primitive.attributes, "WEIGHTS_0");
        if (joints < 0 || weights < 0) return;
        if (attributeOf(primitive.attributes, "JOINTS_1") >= 0)
            _from.messages.say("only the first four joints of each vertex are used");
        part.joints = _from.numbers.whole(joints, 4);
        part.weights = _from.numbers.floats(weights, 4);
        requireGltf(part.joints.size() == 4 * count && part.weights.size() == 4 * count,
                    "the numbers of joints, weights and vertices differ");
    }

    GltfReading& _from;
    GltfMaterials _materials;
};

} // namespace

GltfMeshReader gltfMeshes(GltfReading& from)
{
    return [meshes = std::make_shared<GltfMeshes>(from)](int number,
                                                         const std::vector<double>& weights)
    { return meshes->read(number, weights); };
}

} // namespace osgMidair
