#pragma once

#include "plugin/gltf/GltfScene.h"
#include "plugin/gltf/TinyGltf.h"

#include <osg/Node>

#include <string>

namespace osgMidair
{

/// Makes tags of \a extras, those of what \a where names ("node \"hand\""), at \a node: "haptic"
/// (true, a text, or an object with properties) with the properties beside it, and "obstacle". A
/// property that is misspelt or not understood is kept in the tag, where it is told, and silences
/// if it has to; what is like no property belongs to others and is told here.
void addGltfTags(const tinygltf::Value& extras,
                 const std::string& where,
                 osg::Node& node,
                 GltfMessages& messages);

/// The same for a scene's extras at its root. Those that are named like settings of a HapticScene
/// are GltfMessages::settings() instead.
void addGltfSceneTags(const tinygltf::Scene& scene, osg::Node& root, GltfMessages& messages);

/// True if \a extras say how something is felt.
bool saysHowItFeels(const tinygltf::Value& extras);
/// True if \a extras have "haptic" or "obstacle".
bool isMarked(const tinygltf::Value& extras);

/// The extras of a mesh at one node: those of \a node count before those of \a mesh.
tinygltf::Value joinedExtras(const tinygltf::Value& node, const tinygltf::Value& mesh);

/// True if an extra \a name says that, or how, something is felt, whatever it is beside.
bool isHapticExtra(const std::string& name);

} // namespace osgMidair
