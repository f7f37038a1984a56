#pragma once

#include "plugin/gltf/GltfFile.h"

#include <osg/Geometry>
#include <osg/ref_ptr>

#include <cstdint>
#include <functional>
#include <vector>

namespace osgMidair
{

/// One drawn primitive of a mesh, and the data that move its vertices.
struct GltfPart
{
    osg::ref_ptr<osg::Geometry> geometry;
    /// four joints of the skin, and their weights, of each vertex; empty: none
    std::vector<std::uint32_t> joints;
    std::vector<float> weights;
};

/// Reads mesh \a number anew, with the \a weights of its morph targets; empty: its own ones.
/// Invalid primitives are left out with a message. Throws GltfError if there is no such mesh.
using GltfMeshReader =
    std::function<std::vector<GltfPart>(int number, const std::vector<double>& weights)>;
GltfMeshReader gltfMeshes(GltfReading& from);

} // namespace osgMidair
