#pragma once

#include "plugin/gltf/GltfFile.h"
#include "plugin/gltf/GltfScene.h"
#include "plugin/gltf/TinyGltf.h"

#include <osg/Geometry>
#include <osg/Image>
#include <osg/StateSet>
#include <osg/Vec2>
#include <osg/Vec2d>
#include <osg/ref_ptr>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace osgMidair
{

/// Decodes a model's PNG and JPEG images, each once, by OSG's plugins for them. One that can't be
/// is left out, and told.
class GltfImages
{
public:
    static constexpr std::size_t kMostPixels = std::size_t(64) << 20; ///< of all together
    static constexpr std::size_t kLongestSide = 16384;

    explicit GltfImages(GltfReading& from) :
        _from(from),
        _isDecoded(from.model.images.size()),
        _images(from.model.images.size())
    {
    }

    /// Image \a number; null if there is none.
    osg::ref_ptr<osg::Image> get(int number);

private:
    osg::ref_ptr<osg::Image> decode(int number);

    GltfReading& _from;
    std::size_t _left = kMostPixels;
    std::vector<bool> _isDecoded;
    std::vector<osg::ref_ptr<osg::Image>> _images;
};

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
    explicit GltfMaterials(GltfReading& from) :
        _from(from),
        _images(from),
        _states(from.model.materials.size())
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

    GltfReading& _from;
    GltfImages _images;
    std::vector<osg::ref_ptr<osg::StateSet>> _states;
};

/// One primitive of a mesh as it is drawn, and what moves its vertices.
struct GltfPart
{
    osg::ref_ptr<osg::Geometry> geometry;
    /// four joints of the skin, and their weights, of each vertex; empty: it has none
    std::vector<std::uint32_t> joints;
    std::vector<float> weights;
};

/// Makes geometries of a model's meshes. A primitive that is wrong is left out, and told.
class GltfMeshes
{
public:
    GltfMeshes(GltfReading& from, GltfMaterials& materials) : _from(from), _materials(materials) {}

    /// The parts of mesh \a number, read anew, with the weights of its morph targets: its own ones
    /// if \a weights are empty. Throws GltfError if there is no such mesh.
    std::vector<GltfPart> read(int number, const std::vector<double>& weights);

private:
    GltfPart readPart(const std::string& name,
                      const tinygltf::Primitive& primitive,
                      const std::vector<double>& weights);
    void addMorphs(const tinygltf::Primitive& primitive,
                   const std::vector<double>& weights,
                   osg::Vec3Array& vertices);
    void addCoordinates(const tinygltf::Primitive& primitive,
                        std::size_t count,
                        osg::Geometry& geometry);
    void
    addColors(const tinygltf::Primitive& primitive, std::size_t count, osg::Geometry& geometry);
    void
    addIndices(const tinygltf::Primitive& primitive, std::size_t count, osg::Geometry& geometry);
    void addSkin(const tinygltf::Primitive& primitive, std::size_t count, GltfPart& part);

    GltfReading& _from;
    GltfMaterials& _materials;
};

} // namespace osgMidair
