#pragma once

#include "plugin/gltf/GltfMessages.h"
#include "plugin/gltf/GltfNumbers.h"

#include <osg/Node>

#include <string>
#include <vector>

namespace osgMidair
{

/// \{ Names of what animations move at a node's transform.
constexpr const char* kGltfTranslation = "translation";
constexpr const char* kGltfRotation = "rotation";
constexpr const char* kGltfScale = "scale";
/// \}

/// "node 12": the name by which animations find a node's transform.
std::string gltfTargetName(int node);

/// For each node whether an animation moves it.
std::vector<bool> movedByGltf(const tinygltf::Model& model);

/// Lets an animation manager at \a root play the model's first animation over and over; others are
/// there for programs. A channel that is wrong is left out, and told.
void addGltfAnimations(const tinygltf::Model& model,
                       GltfNumbers& numbers,
                       osg::Node& root,
                       GltfMessages& messages);

} // namespace osgMidair
