#include "plugin/gltf/GltfFile.h"

#include "haptics/base/RegularFile.h"
#include "plugin/gltf/GltfTags.h"
#include "plugin/settings/Grants.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <sstream>
#include <string_view>
#include <system_error>
#include <type_traits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace osgMidair
{

namespace
{

using Json = nlohmann::json;

/// Supported extensions.
constexpr std::array<const char*, 4> kKnown = {"EXT_mesh_gpu_instancing",
                                               "KHR_materials_unlit",
                                               "KHR_mesh_quantization",
                                               "KHR_texture_transform"};

/// Prefixes of extensions that affect only the picture: they don't change what is played.
constexpr std::array<const char*, 6> kDrawnAlone = {
    "KHR_materials_", "KHR_lights_", "KHR_texture_", "EXT_texture_", "EXT_lights_", "KHR_xmp"};

/// \{ Limits of a glTF file.
/// of the file, and of each file that it references
constexpr std::size_t kMostGltfBytes = std::size_t(256) << 20;
constexpr std::size_t kMostGltfBytesInAll = std::size_t(512) << 20; ///< of all these
constexpr std::size_t kMostGltfValues = 2000000; ///< brackets and commas of its JSON
constexpr int kDeepestGltfJson = 32;
constexpr std::size_t kMostGltfBuffers = 64;
/// \}

constexpr std::size_t kHeader = 12;
constexpr std::size_t kChunkHeader = 8;

/// True if \a file is a .glb, by its first bytes.
bool isGlb(const std::string& file)
{
    return file.compare(0, 4, "glTF") == 0;
}

std::uint32_t littleEndian(const std::string& bytes, std::size_t at)
{
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i)
        value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + i])) << (8 * i);
    return value;
}

std::string_view jsonOf(const std::string& file)
{
    if (!isGlb(file)) return file;
    if (file.size() < kHeader + kChunkHeader) throw GltfError("its header is cut off");
    const std::size_t length = littleEndian(file, kHeader);
    if (length > file.size() - kHeader - kChunkHeader)
        failGltf("its JSON should have {} bytes, and is cut off", length);
    return std::string_view(file).substr(kHeader + kChunkHeader, length);
}

// JSON parsers recurse as deep as the text, and take a hundred bytes per value.
void countValues(std::string_view json)
{
    std::size_t values = 0;
    int depth = 0;
    bool isText = false;
    for (std::size_t i = 0; i < json.size(); ++i)
    {
        const char c = json[i];
        if (isText && c == '\\')
            ++i;
        else if (c == '"')
            isText = !isText;
        if (isText) continue;
        if (c == '{' || c == '[') ++depth;
        if (c == '}' || c == ']') --depth;
        if (c == '{' || c == '[' || c == ',') ++values;
        if (depth > kDeepestGltfJson) failGltf("its JSON is more than {} deep", kDeepestGltfJson);
        if (values > kMostGltfValues) failGltf("its JSON has more than {} values", kMostGltfValues);
    }
}

const Json& arrayOf(const Json& gltf, const char* key)
{
    static const Json none = Json::array();
    const auto found = gltf.find(key);
    if (found == gltf.end()) return none;
    if (!found->is_array()) failGltf("\"{}\" should be an array", key);
    return *found;
}

std::uint64_t unsignedOf(const Json& object, const char* key)
{
    if (!object.is_object()) failGltf("the parent of \"{}\" is no object", key);
    const auto found = object.find(key);
    if (found == object.end()) return 0;
    if (!found->is_number_unsigned()) failGltf("\"{}\" should be a whole number, 0 or more", key);
    return found->get<std::uint64_t>();
}

// Each buffer without a name is a copy of the .glb's content.
void screenBuffers(const Json& gltf, bool isBinary)
{
    const Json& buffers = arrayOf(gltf, "buffers");
    if (buffers.size() > kMostGltfBuffers)
        failGltf("{} buffers, should be up to {}", buffers.size(), kMostGltfBuffers);
    for (std::size_t i = 0; i < buffers.size(); ++i)
    {
        if (unsignedOf(buffers[i], "byteLength") > kMostGltfBytes)
            failGltf("buffer {} has more than {} bytes", i, kMostGltfBytes);
        const auto uri = buffers[i].find("uri");
        const bool isNamed = uri != buffers[i].end() && uri->is_string() && *uri != "";
        if (!isNamed && !(isBinary && i == 0))
            failGltf("buffer {} has no uri; only the first one of a .glb may have none", i);
    }
}

// tinygltf doesn't check an image's range in its buffer.
void screenImages(const Json& gltf)
{
    const Json& buffers = arrayOf(gltf, "buffers");
    const Json& views = arrayOf(gltf, "bufferViews");
    const Json& images = arrayOf(gltf, "images");
    for (std::size_t i = 0; i < images.size(); ++i)
    {
        if (!images[i].is_object()) failGltf("image {} is no object", i);
        if (!images[i].contains("bufferView")) continue;
        const std::uint64_t view = unsignedOf(images[i], "bufferView");
        if (view >= views.size()) failGltf("image {} is in no buffer view", i);
        const std::uint64_t buffer = unsignedOf(views[view], "buffer");
        const std::uint64_t begin = unsignedOf(views[view], "byteOffset");
        const std::uint64_t length = unsignedOf(views[view], "byteLength");
        const std::uint64_t room =
            buffer < buffers.size() ? unsignedOf(buffers[buffer], "byteLength") : 0;
        if (length == 0 || begin >= room || length > room - begin)
            failGltf("image {} is not within its buffer", i);
    }
}

// tinygltf truncates whole numbers to 32 bits.
void screenNumbers(const Json& extras, const std::string& owner)
{
    constexpr double kLargest = 2147483647.0;
    for (const auto& [name, value] : extras.items())
        if (value.is_structured())
            screenNumbers(value, owner);
        else if (value.is_number_integer() && std::abs(value.get<double>()) > kLargest)
            failGltf("the extra \"{}\" of {} is {}, should be within {:.0f}",
                     name,
                     owner,
                     value.dump(),
                     kLargest);
}

// Tags count on nodes, meshes and the scene; elsewhere they are ignored with a message.
void tellExtras(const Json& extras, const std::string& owner, GltfMessages& messages)
{
    for (const auto& [name, value] : extras.items())
        if (extras.is_object() && isHapticExtra(name))
            messages.sayUnfollowed(
                fmt::format("{} has the extra \"{}\", which is ignored: put such "
                            "extras on nodes, meshes or the scene",
                            owner,
                            printable(name)));
}

/// Returns true if extras of \a owner ("nodes 3") may be tags.
bool mayHaveTags(const std::string& owner)
{
    const std::string kind = owner.substr(0, owner.find(' '));
    const bool isDirect = std::count(owner.begin(), owner.end(), ' ') == 1;
    return isDirect && (kind == "nodes" || kind == "meshes" || kind == "scenes");
}

// countValues() has limited the depth.
void screenExtras(const Json& within, const std::string& owner, GltfMessages& messages)
{
    for (const auto& [name, value] : within.items())
    {
        if (!value.is_structured()) continue;
        const std::string inner = owner.empty() ? name : fmt::format("{} {}", owner, name);
        if (name != "extras" || !within.is_object())
            screenExtras(value, inner, messages);
        else if (mayHaveTags(owner))
            screenNumbers(value, owner);
        else
            tellExtras(value, owner.empty() ? "the file" : owner, messages);
    }
}

void screenExtensions(const Json& gltf, GltfMessages& messages)
{
    const auto isKnown = [](const std::string& name)
    { return std::find(kKnown.begin(), kKnown.end(), name) != kKnown.end(); };
    for (const Json& one : arrayOf(gltf, "extensionsRequired"))
    {
        const std::string name = one.is_string() ? one.get<std::string>() : one.dump();
        if (!isKnown(name))
            throw GltfError(
                "it needs the extension \"" + name +
                "\", which is not supported: export it without compression and extensions");
    }
    for (const Json& one : arrayOf(gltf, "extensionsUsed"))
    {
        const std::string name = one.is_string() ? one.get<std::string>() : one.dump();
        const auto begins = [&](const char* begin) { return name.rfind(begin, 0) == 0; };
        if (isKnown(name)) continue;
        const std::string text = "it uses the extension \"" + name + "\", which is ignored";
        if (std::any_of(kDrawnAlone.begin(), kDrawnAlone.end(), begins))
            messages.sayOfPicture(text);
        else
            messages.say(text + (begins("MPEG_haptic") ? ": its haptic tracks aren't played" : ""));
    }
}

/// Checks the JSON of \a file, the bytes of a .gltf or .glb, before tinygltf parses it. Throws
/// GltfError for input that would exhaust memory or stack or read beyond a buffer, and for
/// unsupported required extensions. \a messages get the ignored extensions and haptic extras.
void screenGltf(const std::string& file, GltfMessages& messages)
{
    const std::string_view text = jsonOf(file);
    countValues(text);
    const Json gltf = Json::parse(text, nullptr, false);
    if (gltf.is_discarded()) throw GltfError("its JSON is invalid");
    if (!gltf.is_object()) throw GltfError("its JSON should be an object");
    screenExtensions(gltf, messages); // later errors may be due only to these
    screenBuffers(gltf, isGlb(file));
    screenImages(gltf);
    screenExtras(gltf, {}, messages);
}

namespace fs = std::filesystem;

/// The files that a model may reference: those beside it and below its folder.
struct Folder
{
    fs::path path; ///< canonical; empty: none
    std::size_t left = kMostGltfBytesInAll;
    std::string refused; ///< the first name that leads outside or to a special file

    /// Returns the file of \a name, with links resolved; empty if it may not be read.
    fs::path find(const std::string& name)
    {
        std::error_code error;
        fs::path file = fs::canonical(name, error);
        if (error) return {};
        const auto [end, rest] = std::mismatch(path.begin(), path.end(), file.begin(), file.end());
        const bool isInside = !path.empty() && end == path.end() && rest != file.end();
        if (isInside && fs::is_regular_file(file, error)) return file;
        if (refused.empty())
            refused = name + (isInside ? ", which is no regular file" : ", outside of its folder");
        return {};
    }
};

/// Reads a file that a model references.
bool read(std::vector<unsigned char>* out, std::string* error, const std::string& name, void* data)
{
    Folder& folder = *static_cast<Folder*>(data);
    try
    {
        const std::string text = midair::base::readRegularFile(
            folder.find(name).string(), std::min(kMostGltfBytes, folder.left));
        folder.left -= text.size();
        out->assign(text.begin(), text.end());
        return !out->empty();
    }
    catch (const midair::base::FileError& wrong)
    {
        if (error) *error += name + " " + wrong.what() + "\n";
        return false;
    }
}

/// tinygltf's callbacks for files.
tinygltf::FsCallbacks callbacksOf(Folder& files)
{
    return {[](const std::string& name, void* data)
            { return !static_cast<Folder*>(data)->find(name).empty(); },
            // Names are used literally: no "~", no variables, no commands.
            [](const std::string& name, void*) { return name; },
            read,
            [](auto...) { return false; }, // nothing is written
            &files};
}

/// tinygltf's callback for images, which keeps the files' bytes.
bool keepImage(tinygltf::Image* image,
               int,
               std::string*,
               std::string*,
               int,
               int,
               const unsigned char* bytes,
               int size,
               void*)
{
    // Any number of images may refer to one in a buffer.
    if (image->bufferView < 0 && size > 0) image->image.assign(bytes, bytes + size);
    return true;
}

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
        throw wrong(number, fmt::format("its component type {} is unknown", componentType));
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

/// A whole number as it is, or as a fraction of its largest value.
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

/// The numbers of \a count elements of \a width each, which begin at \a offset in \a view, \a
/// stride bytes apart; 0: contiguous.
template<typename T>
std::vector<T> elementsOf(const GltfNumbers& numbers,
                          const tinygltf::Accessor& accessor,
                          int number,
                          int view,
                          std::size_t offset,
                          std::size_t count,
                          int componentType,
                          std::size_t width,
                          std::size_t stride = 0)
{
    constexpr std::size_t kLargestStride = 252; // by the specification
    const std::size_t one = sizeOf(componentType, number);
    const std::size_t element = one * width;
    std::size_t size = 0;
    const unsigned char* bytes = numbers.bytesOf(view, size);
    if (stride == 0) stride = element;
    if (stride < element || stride > std::max(kLargestStride, element))
        throw wrong(number, fmt::format("a stride of {} bytes doesn't fit it", stride));
    // Count and stride are limited: no product overflows.
    if (count > 0 && (offset > size || (count - 1) * stride + element > size - offset))
        throw wrong(number, "it goes beyond its buffer view");
    std::vector<T> values(count * width);
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t k = 0; k < width; ++k)
            values[i * width + k] = numberAt<T>(
                bytes + offset + i * stride + k * one, componentType, accessor.normalized, number);
    return values;
}

/// Replaces the elements of a sparse accessor in \a values.
template<typename T>
void replaceSparse(const GltfNumbers& numbers,
                   const tinygltf::Accessor& accessor,
                   int number,
                   std::size_t width,
                   std::vector<T>& values)
{
    const auto& sparse = accessor.sparse;
    if (sparse.count < 0 || static_cast<std::size_t>(sparse.count) > accessor.count ||
        sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0)
        throw wrong(number, "its sparse part doesn't fit");
    const auto count = static_cast<std::size_t>(sparse.count);
    const auto indices =
        elementsOf<std::uint32_t>(numbers,
                                  accessor,
                                  number,
                                  sparse.indices.bufferView,
                                  static_cast<std::size_t>(sparse.indices.byteOffset),
                                  count,
                                  sparse.indices.componentType,
                                  1);
    const auto given = elementsOf<T>(numbers,
                                     accessor,
                                     number,
                                     sparse.values.bufferView,
                                     static_cast<std::size_t>(sparse.values.byteOffset),
                                     count,
                                     accessor.componentType,
                                     width);
    for (std::size_t i = 0; i < count; ++i)
    {
        if (indices[i] >= accessor.count) throw wrong(number, "its sparse part goes beyond it");
        std::copy_n(&given[i * width], width, &values[indices[i] * width]);
    }
}

} // namespace

tinygltf::Model
readGltfModel(const std::string& bytes, const std::string& folder, GltfMessages& messages)
{
    screenGltf(bytes, messages);
    std::error_code ignored;
    Folder files;
    if (!folder.empty()) files.path = fs::canonical(folder, ignored);
    tinygltf::TinyGLTF reader;
    reader.SetFsCallbacks(callbacksOf(files));
    reader.SetImageLoader(keepImage, nullptr);
    tinygltf::Model model;
    std::string error;
    std::string warning;
    bool good = false;
    const auto size = static_cast<unsigned int>(bytes.size());
    try
    {
        good =
            isGlb(bytes)
                ? reader.LoadBinaryFromMemory(&model,
                                              &error,
                                              &warning,
                                              reinterpret_cast<const unsigned char*>(bytes.data()),
                                              size,
                                              folder)
                : reader.LoadASCIIFromString(&model, &error, &warning, bytes.data(), size, folder);
    }
    catch (const std::exception& thrown) // from nlohmann's JSON and containers
    {
        error = thrown.what();
    }
    if (!files.refused.empty())
        throw GltfError("it names " + files.refused + "; only files beside it are read");
    if (!good) throw GltfError(error.empty() ? "it is invalid" : error.substr(0, error.find('\n')));
    std::istringstream lines(warning);
    for (std::string line; std::getline(lines, line);)
        if (!line.empty()) messages.say(line);
    return model;
}

tinygltf::Model readGltfModel(const std::string& path, GltfMessages& messages)
{
    std::string bytes;
    try
    {
        bytes = midair::base::readRegularFile(path, kMostGltfBytes);
    }
    catch (const midair::base::FileError& error)
    {
        throw GltfError(error.what());
    }
    const fs::path folder = fs::path(path).parent_path();
    return readGltfModel(bytes, folder.empty() ? "." : folder.string(), messages);
}

const tinygltf::Accessor& GltfNumbers::find(int accessor) const
{
    const tinygltf::Accessor* found = gltfEntry(_model.accessors, accessor);
    if (!found) failGltf("there is no accessor {}", accessor);
    return *found;
}

int GltfNumbers::componentsOf(int accessor) const
{
    const int count =
        tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(find(accessor).type));
    if (count < 1) throw wrong(accessor, "its type is unknown");
    return count;
}

const unsigned char* GltfNumbers::bytesOf(int view, std::size_t& size) const
{
    const tinygltf::BufferView* found = gltfEntry(_model.bufferViews, view);
    if (!found) failGltf("there is no buffer view {}", view);
    const tinygltf::BufferView& one = *found;
    const tinygltf::Buffer* buffer = gltfEntry(_model.buffers, one.buffer);
    if (!buffer) failGltf("buffer view {} has no buffer", view);
    const std::vector<unsigned char>& bytes = buffer->data;
    if (one.byteOffset > bytes.size() || one.byteLength > bytes.size() - one.byteOffset)
        failGltf("buffer view {} goes beyond its buffer", view);
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
                    fmt::format("with it the file exceeds {} numbers, the most "
                                "possible",
                                kMost));
    _left -= accessor.count * width;
    std::vector<T> values;
    if (accessor.bufferView < 0)
        values.resize(accessor.count * width);
    else
    {
        const tinygltf::BufferView* view = gltfEntry(_model.bufferViews, accessor.bufferView);
        values = elementsOf<T>(*this,
                               accessor,
                               number,
                               accessor.bufferView,
                               accessor.byteOffset,
                               accessor.count,
                               accessor.componentType,
                               width,
                               view ? view->byteStride : 0);
    }
    if (accessor.sparse.isSparse) replaceSparse(*this, accessor, number, width, values);
    return values;
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
