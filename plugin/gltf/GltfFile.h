#pragma once

#include "plugin/gltf/GltfScene.h"
#include "plugin/gltf/TinyGltf.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

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

/// Reads the numbers that accessors stand for, sparse ones too, and checks all that they refer to;
/// throws GltfError, which names the accessor.
class GltfNumbers
{
public:
    /// Numbers that are read from one file; a file may name the same ones any number of times.
    static constexpr std::size_t kMost = std::size_t(64) << 20;

    explicit GltfNumbers(const tinygltf::Model& model) : _model(model) {}

    /// Numbers of \a components each: floats, or normalized whole ones. All are finite.
    std::vector<float> floats(int accessor, int components);
    /// Whole numbers of \a components each (indices, joints).
    std::vector<std::uint32_t> whole(int accessor, int components);
    /// 1 .. 16; of the accessor's type.
    int componentsOf(int accessor) const;

    /// The bytes of a buffer view. Throws GltfError.
    const unsigned char* bytesOf(int view, std::size_t& size) const;

private:
    const tinygltf::Accessor& find(int accessor) const;
    template<typename T>
    std::vector<T> read(int accessor, int components);
    template<typename T>
    void fill(const tinygltf::Accessor& accessor,
              int number,
              int components,
              std::vector<T>& values) const;
    template<typename T>
    void replace(const tinygltf::Accessor& accessor,
                 int number,
                 int components,
                 std::vector<T>& values) const;

    const tinygltf::Model& _model;
    std::size_t _left = kMost;
};

/// A model that is being read: what all who make something of it use.
struct GltfReading
{
    const tinygltf::Model& model;
    GltfNumbers& numbers;
    GltfMessages& messages;
};

} // namespace osgMidair
