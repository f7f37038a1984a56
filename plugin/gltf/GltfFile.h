#pragma once

#include "plugin/gltf/GltfScene.h"
#include "plugin/gltf/TinyGltf.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace osgMidair
{

/// Throws GltfError with \a what unless \a isRight.
inline void requireGltf(bool isRight, const char* what)
{
    if (!isRight) throw GltfError(what);
}

/// The entry of \a all that a file refers to by \a number; null if there is none.
template<class T>
const T* gltfEntry(const std::vector<T>& all, int number)
{
    const auto at = static_cast<std::size_t>(number);
    return number >= 0 && at < all.size() ? &all[at] : nullptr;
}

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
