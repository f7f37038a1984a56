#include "plugin/gltf/GltfNumbers.h"

#include "plugin/gltf/GltfMessages.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

GltfError wrong(int number, const std::string& why)
{
    return GltfError(fmt::format("accessor {}: {}", number, why));
}

std::size_t sizeOf(int componentType, int number)
{
    switch (componentType)
    {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
        return 4;
    default:
        throw wrong(number, fmt::format("its component type {} is not known", componentType));
    }
}

template<typename Stored>
Stored load(const unsigned char* from)
{
    Stored value;
    std::memcpy(
        &value, from, sizeof value); // little-endian, as the processors are that OSG runs on
    return value;
}

/// A whole number as it is, or as the share of its largest value.
template<typename Stored, typename T>
T wholeAs(const unsigned char* from, bool isNormalized)
{
    const Stored value = load<Stored>(from);
    if constexpr (std::is_floating_point_v<T>)
        if (isNormalized)
            return std::max(
                T(-1), static_cast<T>(value) / static_cast<T>(std::numeric_limits<Stored>::max()));
    return static_cast<T>(value);
}

template<typename T>
T numberAt(const unsigned char* from, int componentType, bool isNormalized, int number)
{
    switch (componentType)
    {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return wholeAs<std::uint8_t, T>(from, isNormalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return wholeAs<std::uint16_t, T>(from, isNormalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        return wholeAs<std::uint32_t, T>(from, isNormalized);
    default:
        break;
    }
    if constexpr (std::is_floating_point_v<T>) switch (componentType)
        {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            return wholeAs<std::int8_t, T>(from, isNormalized);
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return wholeAs<std::int16_t, T>(from, isNormalized);
        case TINYGLTF_COMPONENT_TYPE_FLOAT:
        {
            const float value = load<float>(from);
            if (!std::isfinite(value)) throw wrong(number, "a number in it isn't finite");
            return value;
        }
        default:
            break;
        }
    throw wrong(number, "its numbers should be whole and unsigned");
}

/// Where \a count elements of \a element bytes, \a stride apart, begin in \a size bytes.
std::size_t placeOf(std::size_t offset,
                    std::size_t count,
                    std::size_t stride,
                    std::size_t element,
                    std::size_t size,
                    int number)
{
    // The count is limited, the stride too: no product overflows.
    if (count > 0 && (offset > size || (count - 1) * stride + element > size - offset))
        throw wrong(number, "it goes beyond its buffer view");
    return offset;
}

} // namespace

const tinygltf::Accessor& GltfNumbers::find(int accessor) const
{
    if (accessor < 0 || static_cast<std::size_t>(accessor) >= _model.accessors.size())
        throw GltfError(fmt::format("there is no accessor {}", accessor));
    return _model.accessors[static_cast<std::size_t>(accessor)];
}

int GltfNumbers::componentsOf(int accessor) const
{
    const int count =
        tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(find(accessor).type));
    if (count < 1) throw wrong(accessor, "its type is not known");
    return count;
}

const unsigned char* GltfNumbers::bytesOf(int view, std::size_t& size) const
{
    if (view < 0 || static_cast<std::size_t>(view) >= _model.bufferViews.size())
        throw GltfError(fmt::format("there is no buffer view {}", view));
    const tinygltf::BufferView& one = _model.bufferViews[static_cast<std::size_t>(view)];
    if (one.buffer < 0 || static_cast<std::size_t>(one.buffer) >= _model.buffers.size())
        throw GltfError(fmt::format("buffer view {} has no buffer", view));
    const std::vector<unsigned char>& bytes =
        _model.buffers[static_cast<std::size_t>(one.buffer)].data;
    if (one.byteOffset > bytes.size() || one.byteLength > bytes.size() - one.byteOffset)
        throw GltfError(fmt::format("buffer view {} goes beyond its buffer", view));
    size = one.byteLength;
    return bytes.data() + one.byteOffset;
}

template<typename T>
std::vector<T> GltfNumbers::read(int number, int components)
{
    const tinygltf::Accessor& accessor = find(number);
    if (componentsOf(number) != components)
        throw wrong(
            number,
            fmt::format("it has {} components, should have {}", componentsOf(number), components));
    const auto width = static_cast<std::size_t>(components);
    if (accessor.count > _left / width)
        throw wrong(number,
                    fmt::format("with it the file has more than {} numbers, which are the most "
                                "possible",
                                kMost));
    _left -= accessor.count * width;
    std::vector<T> values(accessor.count * width, T(0));
    if (accessor.bufferView >= 0) fill(accessor, number, components, values);
    if (accessor.sparse.isSparse) replace(accessor, number, components, values);
    return values;
}

template<typename T>
void GltfNumbers::fill(const tinygltf::Accessor& accessor,
                       int number,
                       int components,
                       std::vector<T>& values) const
{
    constexpr std::size_t kLargestStride = 252; // by the specification
    const std::size_t one = sizeOf(accessor.componentType, number);
    const auto width = static_cast<std::size_t>(components);
    std::size_t size = 0;
    const unsigned char* bytes = bytesOf(accessor.bufferView, size);
    const std::size_t given =
        _model.bufferViews[static_cast<std::size_t>(accessor.bufferView)].byteStride;
    const std::size_t stride = given == 0 ? one * width : given;
    if (stride < one * width || stride > std::max(kLargestStride, one * width))
        throw wrong(number, fmt::format("a stride of {} bytes doesn't fit it", stride));
    bytes += placeOf(accessor.byteOffset, accessor.count, stride, one * width, size, number);
    for (std::size_t i = 0; i < accessor.count; ++i)
        for (std::size_t k = 0; k < width; ++k)
            values[i * width + k] = numberAt<T>(
                bytes + i * stride + k * one, accessor.componentType, accessor.normalized, number);
}

template<typename T>
void GltfNumbers::replace(const tinygltf::Accessor& accessor,
                          int number,
                          int components,
                          std::vector<T>& values) const
{
    const auto& sparse = accessor.sparse;
    if (sparse.count < 0 || static_cast<std::size_t>(sparse.count) > accessor.count ||
        sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0)
        throw wrong(number, "what replaces some of it doesn't fit");
    const auto count = static_cast<std::size_t>(sparse.count);
    const auto width = static_cast<std::size_t>(components);
    const std::size_t index = sizeOf(sparse.indices.componentType, number);
    const std::size_t one = sizeOf(accessor.componentType, number);
    std::size_t size = 0;
    const unsigned char* indices = bytesOf(sparse.indices.bufferView, size);
    indices += placeOf(
        static_cast<std::size_t>(sparse.indices.byteOffset), count, index, index, size, number);
    const unsigned char* from = bytesOf(sparse.values.bufferView, size);
    from += placeOf(static_cast<std::size_t>(sparse.values.byteOffset),
                    count,
                    one * width,
                    one * width,
                    size,
                    number);
    for (std::size_t i = 0; i < count; ++i)
    {
        const auto at = numberAt<std::uint32_t>(
            indices + i * index, sparse.indices.componentType, false, number);
        if (at >= accessor.count) throw wrong(number, "what replaces some of it goes beyond it");
        for (std::size_t k = 0; k < width; ++k)
            values[at * width + k] = numberAt<T>(
                from + (i * width + k) * one, accessor.componentType, accessor.normalized, number);
    }
}

std::vector<float> GltfNumbers::floats(int accessor, int components)
{
    return read<float>(accessor, components);
}

std::vector<std::uint32_t> GltfNumbers::whole(int accessor, int components)
{
    return read<std::uint32_t>(accessor, components);
}

} // namespace osgMidair
