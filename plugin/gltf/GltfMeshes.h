#pragma once

#include "plugin/gltf/GltfMaterials.h"
#include "plugin/gltf/GltfMessages.h"
#include "plugin/gltf/GltfNumbers.h"

#include <osg/Geometry>
#include <osg/ref_ptr>

#include <cstdint>
#include <string>
#include <vector>

namespace osgMidair
{

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
