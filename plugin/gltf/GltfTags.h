#pragma once

#include "plugin/gltf/GltfMessages.h"
#include "plugin/gltf/TinyGltf.h"

#include <osg/Node>

namespace osgMidair
{

/// Makes tags of the extras of glTF node \a from, at \a node: "haptic" (true, or a text) with the
/// properties beside it, and "obstacle". A property that is misspelt or not understood is kept in
/// the tag, where it is told, and silences if it has to; what is like no property belongs to others
/// and is told here.
void addGltfTags(const tinygltf::Node& from, osg::Node& node, GltfMessages& messages);

} // namespace osgMidair
