#pragma once

#include "plugin/gltf/GltfMessages.h"
#include "plugin/gltf/TinyGltf.h"

#include <cstddef>
#include <string>

namespace osgMidair
{

/// \{ Limits of a glTF file.
constexpr std::size_t kMostGltfBytes = std::size_t(256) << 20; ///< of it, and of each file it names
constexpr std::size_t kMostGltfBytesInAll = std::size_t(512) << 20; ///< of all these
constexpr std::size_t kMostGltfValues = 2000000; ///< brackets and commas of its JSON
constexpr int kDeepestGltfJson = 32;
constexpr std::size_t kMostGltfBuffers = 64;
/// \}

/// Looks at the JSON of \a file, the bytes of a .gltf or .glb, before tinygltf does: throws
/// GltfError for what would make that take more memory or stack than there is, or look beyond a
/// buffer, and for what needs an extension that the kit doesn't know. \a messages get the
/// extensions and the haptic extras that aren't followed.
void screenGltf(const std::string& file, GltfMessages& messages);

/// True if \a file is a .glb by its first bytes.
bool isGlb(const std::string& file);

/// Reads the file at \a path, regular and of a limited size, and what it names beside it or below
/// its folder; a name of anything else throws. Images are left as their files' bytes, those within
/// buffers as they are there. Throws GltfError.
tinygltf::Model readGltfModel(const std::string& path, GltfMessages& messages);

/// The same of a file's bytes. \a folder: where it may name files; empty: nowhere.
tinygltf::Model
readGltfModel(const std::string& bytes, const std::string& folder, GltfMessages& messages);

} // namespace osgMidair
