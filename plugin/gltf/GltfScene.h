#pragma once

#include "plugin/gltf/GltfMessages.h"

#include <osg/Node>
#include <osg/ref_ptr>

#include <string>

namespace osgMidair
{

/// Reads a glTF 2.0 model, .gltf or .glb: nodes, meshes, base colours, textures, skins, animations,
/// and the extras of nodes, meshes and the scene as tags; metres, turned from y up to OSG's z up.
/// Throws GltfError, which says what is wrong; what is left out of a model that is read is in \a
/// messages.
osg::ref_ptr<osg::Node> readGltf(const std::string& path, GltfMessages& messages);

/// The same of a file's bytes, which name no other file.
osg::ref_ptr<osg::Node> readGltfBytes(const std::string& bytes, GltfMessages& messages);

/// The same, telling the messages as OSG's warnings and notices, too; null, with the reason in \a
/// error, if it isn't read.
osg::ref_ptr<osg::Node>
readGltfAndTell(const std::string& path, GltfMessages& messages, std::string& error);
/// The same for who follows nothing of what the scene says of the array: that is told, too.
osg::ref_ptr<osg::Node> readGltfAndTell(const std::string& path, std::string& error);

} // namespace osgMidair
