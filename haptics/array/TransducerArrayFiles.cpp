#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"
#include "haptics/base/OwnFolder.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/UserEnvironment.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

namespace fs = std::filesystem;

constexpr std::size_t kMostBytes = std::size_t(32) << 20;

// The user's folders come first, so that a measured array can replace a shipped one of the same
// name.
std::vector<fs::path> arrayFolders()
{
    std::vector<fs::path> folders;
    if (const auto own = base::userVariable("OSG_MIDAIR_ARRAYS"))
    {
        std::istringstream list(*own);
        for (std::string folder; std::getline(list, folder, ':');)
            if (!folder.empty()) folders.emplace_back(folder);
    }
    // Beside the library or the program, wherever the installed prefix has been moved to.
    if (const fs::path own = base::ownFolder(); !own.empty())
        for (const char* place : {MIDAIR_ARRAYS_FROM_LIBRARY, MIDAIR_ARRAYS_FROM_PROGRAM})
            folders.push_back((own / place).lexically_normal());
    folders.emplace_back(MIDAIR_ARRAYS_INSTALLED);
    folders.emplace_back(MIDAIR_ARRAYS_SOURCE);
    return folders;
}

TransducerArray read(const fs::path& path)
{
    std::error_code ignored;
    if (fs::is_directory(path, ignored))
        throw base::InputError("array file '" + path.string() +
                               "' is a folder; a JSON file is expected");
    std::string text;
    try
    {
        text = base::readRegularFile(path.string(), kMostBytes);
    }
    catch (const base::FileError& error)
    {
        throw base::InputError("array file '" + path.string() + "' " + error.what());
    }
    TransducerArray array = TransducerArray::fromJson(text, path.string());
    if (array.name.empty()) array.name = path.stem().string();
    return array;
}

} // namespace

std::vector<std::string> TransducerArray::names()
{
    std::vector<std::string> shipped;
    for (const fs::path& folder : arrayFolders())
    {
        std::error_code error;
        for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
             entry.increment(error))
            if (entry->path().extension() == ".json")
                shipped.push_back(entry->path().stem().string());
    }
    std::sort(shipped.begin(), shipped.end());
    shipped.erase(std::unique(shipped.begin(), shipped.end()), shipped.end());
    std::vector<std::string> names = {"octagon", "board"};
    names.insert(names.end(), shipped.begin(), shipped.end());
    return names;
}

std::string TransducerArray::fileOf(const std::string& nameOrPath)
{
    if (nameOrPath.empty() || nameOrPath == "octagon" || nameOrPath == "board") return {};
    const fs::path given(nameOrPath);
    std::error_code ignored;
    if (!given.has_parent_path() && given.extension() != ".json")
        for (const fs::path& folder : arrayFolders())
        {
            const fs::path candidate = folder / (nameOrPath + ".json");
            if (fs::exists(candidate, ignored)) return candidate.string();
        }
    return fs::exists(given, ignored) ? given.string() : std::string();
}

TransducerArray TransducerArray::load(const std::string& nameOrPath)
{
    if (nameOrPath == "octagon") return octagonalPrism();
    if (nameOrPath == "board") return singleBoard();

    const std::string file = fileOf(nameOrPath);
    if (!file.empty()) return read(file);

    throw base::InputError(fmt::format("array '{}': there is no such file, and no array of that "
                                       "name; known are {}, or the path of a JSON file",
                                       nameOrPath,
                                       fmt::join(names(), ", ")));
}

void TransducerArray::save(const std::string& path) const
{
    std::ofstream file(path, std::ios::binary);
    file << toJson();
    file.close();
    if (!file) throw base::InputError("array file '" + path + "' can't be written");
}

} // namespace midair::haptics
