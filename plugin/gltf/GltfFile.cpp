#include "plugin/gltf/GltfFile.h"

#include "haptics/base/RegularFile.h"
#include "plugin/gltf/GltfMessages.h"
#include "plugin/gltf/GltfScreening.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

namespace osgMidair
{

namespace
{

namespace fs = std::filesystem;

/// The files that a model may name: those beside it and below its folder.
struct Folder
{
    fs::path path; ///< canonical; empty: none
    std::size_t left = kMostGltfBytesInAll;
    std::string refused; ///< the first name that leads outside, or to what is no regular file

    /// Returns the file that \a name leads to, links followed; empty if it may not be read.
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

Folder& folderOf(void* data)
{
    return *static_cast<Folder*>(data);
}

bool exists(const std::string& name, void* data)
{
    return !folderOf(data).find(name).empty();
}

// Names are taken as they are: no "~", no variables, no commands.
std::string expand(const std::string& name, void* /*data*/)
{
    return name;
}

bool read(std::vector<unsigned char>* out, std::string* error, const std::string& name, void* data)
{
    Folder& folder = folderOf(data);
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

bool write(std::string* /*error*/,
           const std::string& /*name*/,
           const std::vector<unsigned char>& /*bytes*/,
           void* /*data*/)
{
    return false;
}

bool keepImage(tinygltf::Image* image,
               const int /*index*/,
               std::string* /*error*/,
               std::string* /*warning*/,
               int /*width*/,
               int /*height*/,
               const unsigned char* bytes,
               int size,
               void* /*data*/)
{
    // One in a buffer may be said to be any number of images.
    if (image->bufferView < 0 && size > 0) image->image.assign(bytes, bytes + size);
    return true;
}

/// The first line of what tinygltf says.
std::string firstLine(const std::string& text)
{
    return text.substr(0, text.find('\n'));
}

void sayLines(const std::string& text, GltfMessages& messages)
{
    for (std::size_t begin = 0; begin < text.size();)
    {
        const std::size_t end = std::min(text.find('\n', begin), text.size());
        if (end > begin) messages.say(text.substr(begin, end - begin));
        begin = end + 1;
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
    reader.SetFsCallbacks({exists, expand, read, write, &files});
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
    catch (const std::exception& thrown) // by nlohmann's JSON and containers
    {
        error = thrown.what();
    }
    if (!files.refused.empty())
        throw GltfError("it names " + files.refused + "; only files beside it are read");
    if (!good) throw GltfError(error.empty() ? "it is not understood" : firstLine(error));
    sayLines(warning, messages);
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

} // namespace osgMidair
