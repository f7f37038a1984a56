#include "plugin/gltf/GltfMaterials.h"

#include <osg/AlphaFunc>
#include <osg/Material>
#include <osg/Texture2D>

#include <algorithm>

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

} // namespace

const tinygltf::Material* GltfMaterials::find(int number) const
{
    if (number < 0 || static_cast<std::size_t>(number) >= _model.materials.size()) return nullptr;
    return &_model.materials[static_cast<std::size_t>(number)];
}

int GltfMaterials::coordinatesOf(int number) const
{
    const tinygltf::Material* material = find(number);
    if (!material || material->pbrMetallicRoughness.baseColorTexture.index < 0) return -1;
    return std::clamp(material->pbrMetallicRoughness.baseColorTexture.texCoord, 0, 7);
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
    if (info.extensions.count("KHR_texture_transform") > 0)
        _messages.sayOfPicture("its textures are not moved as KHR_texture_transform says");
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
