#include "plugin/gltf/GltfMaterials.h"

#include <osg/AlphaFunc>
#include <osg/Material>
#include <osg/Texture2D>

#include <algorithm>
#include <cmath>

namespace osgMidair
{

namespace
{

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
    if (number < 0 || static_cast<std::size_t>(number) >= _model.materials.size()) return nullptr;
    return &_model.materials[static_cast<std::size_t>(number)];
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
        _messages.sayOfPicture("of its materials the base colour is drawn, and no other texture");
    return state;
}

void GltfMaterials::addTexture(const tinygltf::TextureInfo& info, osg::StateSet& state)
{
    if (info.index < 0 || static_cast<std::size_t>(info.index) >= _model.textures.size()) return;
    const tinygltf::Texture& texture = _model.textures[static_cast<std::size_t>(info.index)];
    const osg::ref_ptr<osg::Image> image = _images.get(texture.source);
    if (!image) return;
    const osg::ref_ptr<osg::Texture2D> drawn = new osg::Texture2D(image);
    drawn->setWrap(osg::Texture::WRAP_S, osg::Texture::REPEAT);
    drawn->setWrap(osg::Texture::WRAP_T, osg::Texture::REPEAT);
    if (texture.sampler >= 0 && static_cast<std::size_t>(texture.sampler) < _model.samplers.size())
    {
        const tinygltf::Sampler& sampler =
            _model.samplers[static_cast<std::size_t>(texture.sampler)];
        drawn->setWrap(osg::Texture::WRAP_S, wrapOf(sampler.wrapS));
        drawn->setWrap(osg::Texture::WRAP_T, wrapOf(sampler.wrapT));
        if (sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST)
            drawn->setFilter(osg::Texture::MAG_FILTER, osg::Texture::NEAREST);
    }
    state.setTextureAttributeAndModes(0, drawn);
}

} // namespace osgMidair
