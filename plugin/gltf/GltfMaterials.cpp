#include "plugin/gltf/GltfMaterials.h"

#include "plugin/gltf/GltfMessages.h"

#include <osg/AlphaFunc>
#include <osg/Material>
#include <osg/Texture2D>
#include <osgDB/Registry>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

/// Width and height as the header of a PNG or JPEG file says, before anything is decoded: a file of
/// some bytes may say that it has gigabytes.
struct ImageSize
{
    std::size_t width = 0; ///< 0: no PNG nor JPEG
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

/// A JPEG file is a row of segments, of which one begins a frame and has its size.
ImageSize jpegSize(const unsigned char* bytes, std::size_t size)
{
    for (std::size_t at = 2; at + 9 <= size && bytes[at] == 0xFF;)
    {
        const unsigned char marker = bytes[at + 1];
        if (marker == 0xFF) // fills
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

/// Member \a name of an extension as \a count numbers; \a otherwise if it has none. Throws
/// GltfError.
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

} // namespace

osg::ref_ptr<osg::Image> GltfImages::get(int number)
{
    if (number < 0 || static_cast<std::size_t>(number) >= _images.size()) return nullptr;
    const auto at = static_cast<std::size_t>(number);
    if (!_isDecoded[at])
    {
        _isDecoded[at] = true;
        _images[at] = decode(number);
    }
    return _images[at];
}

osg::ref_ptr<osg::Image> GltfImages::decode(int number)
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
            why = fmt::format(
                "{} x {} pixels are more than there is room for", seen.width, seen.height);
        else if (reader = osgDB::Registry::instance()->getReaderWriterForExtension(seen.extension);
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

// As the extension's example has it: a turn by 90 degrees leads (u v) to (v -u).
osg::Vec2 GltfCoordinates::inImage(const osg::Vec2& coordinates) const
{
    const double u = coordinates.x() * scale.x();
    const double v = coordinates.y() * scale.y();
    const double c = std::cos(rotation_rad);
    const double s = std::sin(rotation_rad);
    return osg::Vec2d(offset.x() + c * u + s * v, 1.0 - (offset.y() - s * u + c * v));
}

const tinygltf::Material* GltfMaterials::find(int number) const
{
    if (number < 0 || static_cast<std::size_t>(number) >= _from.model.materials.size())
        return nullptr;
    return &_from.model.materials[static_cast<std::size_t>(number)];
}

GltfCoordinates GltfMaterials::coordinatesOf(int number) const
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
    way.set =
        static_cast<int>(std::max(0.0, numbersIn(found->second, "texCoord", {double(way.set)})[0]));
    return way;
}

osg::ref_ptr<osg::StateSet> GltfMaterials::get(int number)
{
    const tinygltf::Material* material = find(number);
    if (!material) return nullptr;
    osg::ref_ptr<osg::StateSet>& state = _states[static_cast<std::size_t>(number)];
    if (!state) state = make(*material);
    return state;
}

osg::ref_ptr<osg::StateSet> GltfMaterials::make(const tinygltf::Material& material)
{
    const osg::ref_ptr<osg::StateSet> state = new osg::StateSet;
    const osg::ref_ptr<osg::Material> drawn = new osg::Material;
    osg::Vec4 color(1, 1, 1, 1);
    const std::vector<double>& factor = material.pbrMetallicRoughness.baseColorFactor;
    for (unsigned int i = 0; i < 4 && i < factor.size(); ++i)
        color[i] = static_cast<float>(std::clamp(factor[i], 0.0, 1.0));
    // Colours of vertices take the place of the material's.
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
            "of its materials the base colour is drawn, and no other texture");
    return state;
}

void GltfMaterials::addTexture(const tinygltf::TextureInfo& info, osg::StateSet& state)
{
    if (info.index < 0 || static_cast<std::size_t>(info.index) >= _from.model.textures.size())
        return;
    const tinygltf::Texture& texture = _from.model.textures[static_cast<std::size_t>(info.index)];
    const osg::ref_ptr<osg::Image> image = _images.get(texture.source);
    if (!image) return;
    const osg::ref_ptr<osg::Texture2D> drawn = new osg::Texture2D(image);
    drawn->setWrap(osg::Texture::WRAP_S, osg::Texture::REPEAT);
    drawn->setWrap(osg::Texture::WRAP_T, osg::Texture::REPEAT);
    if (texture.sampler >= 0 &&
        static_cast<std::size_t>(texture.sampler) < _from.model.samplers.size())
    {
        const tinygltf::Sampler& sampler =
            _from.model.samplers[static_cast<std::size_t>(texture.sampler)];
        drawn->setWrap(osg::Texture::WRAP_S, wrapOf(sampler.wrapS));
        drawn->setWrap(osg::Texture::WRAP_T, wrapOf(sampler.wrapT));
        if (sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST)
            drawn->setFilter(osg::Texture::MAG_FILTER, osg::Texture::NEAREST);
    }
    state.setTextureAttributeAndModes(0, drawn);
}

} // namespace osgMidair
