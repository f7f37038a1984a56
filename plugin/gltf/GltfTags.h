#pragma once

#include "plugin/gltf/GltfScene.h"
#include "plugin/gltf/TinyGltf.h"

#include <osg/Node>

#include <string>

namespace osgMidair
{

/// Makes tags at \a node from \a extras, those of \a where ("node \"hand\""): "haptic" (true, a
/// text, or an object with properties) with the properties beside it, "reflector" with its own, and
/// "obstacle". A misspelt or invalid property stays in the tag, whose reader reports it and
/// silences the scene if necessary; a name that resembles no property is ignored with a message.
void addGltfTags(const tinygltf::Value& extras,
                 const std::string& where,
                 osg::Node& node,
                 GltfMessages& messages);

/// The same for a scene's extras at its root. Names of a HapticScene's settings go to
/// GltfMessages::settings() instead.
void addGltfSceneTags(const tinygltf::Scene& scene, osg::Node& root, GltfMessages& messages);

/// True if \a extras have haptic properties.
bool saysHowItFeels(const tinygltf::Value& extras);
/// True if \a extras have a tag.
bool isMarked(const tinygltf::Value& extras);

/// Joins the extras of a mesh at one node: those of \a node override those of \a mesh.
tinygltf::Value joinedExtras(const tinygltf::Value& node, const tinygltf::Value& mesh);

/// True if an extra \a name is haptic, whatever stands beside it.
bool isHapticExtra(const std::string& name);

} // namespace osgMidair
