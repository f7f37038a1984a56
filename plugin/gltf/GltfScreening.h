#pragma once

#include "plugin/gltf/GltfMessages.h"
#include "plugin/settings/ForTests.h"

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
OSGMIDAIR_FOR_TESTS void screenGltf(const std::string& file, GltfMessages& messages);

/// True if \a file is a .glb by its first bytes.
OSGMIDAIR_FOR_TESTS bool isGlb(const std::string& file);

} // namespace osgMidair
