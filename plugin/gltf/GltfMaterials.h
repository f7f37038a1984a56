#pragma once

#include "plugin/gltf/GltfImages.h"

#include <osg/StateSet>
#include <osg/ref_ptr>

#include <string>
#include <vector>

namespace osgMidair
{

/// Base colours and their textures; what else a material has isn't drawn.
class GltfMaterials
{
public:
    GltfMaterials(const tinygltf::Model& model,
                  const GltfNumbers& numbers,
                  GltfMessages& messages) :
        _model(model),
        _messages(messages),
        _images(model, numbers, messages),
        _states(model.materials.size())
    {
    }

    /// The state of material \a number; null if there is none.
    osg::ref_ptr<osg::StateSet> get(int number);
    /// The set of texture coordinates of its base colour: 0 for TEXCOORD_0; -1: it has no texture.
    int coordinatesOf(int number) const;

private:
    const tinygltf::Material* find(int number) const;
    osg::ref_ptr<osg::StateSet> make(const tinygltf::Material& material);
    void addTexture(const tinygltf::TextureInfo& info, osg::StateSet& state);

    const tinygltf::Model& _model;
    GltfMessages& _messages;
    GltfImages _images;
    std::vector<osg::ref_ptr<osg::StateSet>> _states;
};

} // namespace osgMidair
