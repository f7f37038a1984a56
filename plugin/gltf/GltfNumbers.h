#pragma once

#include "plugin/gltf/GltfMessages.h"
#include "plugin/gltf/TinyGltf.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace osgMidair
{

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
