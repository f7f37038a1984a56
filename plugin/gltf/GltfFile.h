#pragma once

#include "plugin/gltf/GltfMessages.h"
#include "plugin/gltf/TinyGltf.h"

#include <string>

namespace osgMidair
{

/// Reads the file at \a path, regular and of a limited size, and what it names beside it or below
/// its folder; a name of anything else throws. Images are left as their files' bytes, those within
/// buffers as they are there. Throws GltfError.
tinygltf::Model readGltfModel(const std::string& path, GltfMessages& messages);

/// The same of a file's bytes. \a folder: where it may name files; empty: nowhere.
tinygltf::Model
readGltfModel(const std::string& bytes, const std::string& folder, GltfMessages& messages);

} // namespace osgMidair
