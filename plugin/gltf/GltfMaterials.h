#pragma once

#include "plugin/gltf/GltfImages.h"

#include <osg/StateSet>
#include <osg/Vec2>
#include <osg/Vec2d>
#include <osg/ref_ptr>

#include <string>
#include <vector>

namespace osgMidair
{

/// How a primitive's texture coordinates lead to its material's image.
struct GltfCoordinates
{
    int set = -1; ///< 0 for TEXCOORD_0; -1: there is no texture
    /// \{ KHR_texture_transform
    osg::Vec2d offset;
    osg::Vec2d scale = osg::Vec2d(1, 1);
    double rotation_rad = 0.0;
    /// \}

    /// The place in OSG's image, which begins at the bottom; glTF's begins at the top.
    osg::Vec2 inImage(const osg::Vec2& coordinates) const;
};

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
    /// Where its base colour's texture is. Throws GltfError.
    GltfCoordinates coordinatesOf(int number) const;

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
