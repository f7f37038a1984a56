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

/// Returns entry \a number of \a all; null if there is none.
template<class T>
const T* gltfEntry(const std::vector<T>& all, int number)
{
    const auto at = static_cast<std::size_t>(number);
    return number >= 0 && at < all.size() ? &all[at] : nullptr;
}

/// Reads the file at \a path, regular and of limited size, and files that it references beside it
/// or below its folder; throws for others. Images are kept as their files' bytes, those in buffers
/// stay there. Throws GltfError.
tinygltf::Model readGltfModel(const std::string& path, GltfMessages& messages);

/// The same for a file's bytes. \a folder: where referenced files may be; empty: nowhere.
tinygltf::Model
readGltfModel(const std::string& bytes, const std::string& folder, GltfMessages& messages);

/// Reads the numbers of accessors, including sparse ones, and checks all their references; throws
/// GltfError, which names the accessor.
class GltfNumbers
{
public:
    /// Limit on numbers read from one file, because a file may reference the same ones any number
    /// of times.
    static constexpr std::size_t kMost = std::size_t(64) << 20;

    explicit GltfNumbers(const tinygltf::Model& model) : _model(model) {}

    /// Elements of \a components floats or normalized whole numbers each. All are finite.
    std::vector<float> floats(int accessor, int components);
    /// Elements of \a components whole numbers each (indices, joints).
    std::vector<std::uint32_t> whole(int accessor, int components);
    /// 1 .. 16; by the accessor's type.
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

/// A model being read: state shared by its readers.
struct GltfReading
{
    const tinygltf::Model& model;
    GltfNumbers& numbers;
    GltfMessages& messages;
};

} // namespace osgMidair
