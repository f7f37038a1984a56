// Finds, reads and writes array files; TransducerArrayJson.cpp reads their JSON.
#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"
#include "haptics/base/OwnFolder.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/UserEnvironment.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

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
    const std::string text =
        base::readRegularFile(path.string(), kMostBytes, "array file '" + path.string() + "' ");
    TransducerArray array = TransducerArray::fromJson(text, path.string());
    if (array.name.empty()) array.name = path.stem().string();
    return array;
}

using Json = nlohmann::ordered_json;

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

std::string TransducerArray::toJson() const
{
    std::string error;
    if (!isValid(&error)) throw base::InputError("array '" + name + "' can't be written: " + error);
    Json head;
    head["name"] = name;
    head["frequency_Hz"] = frequency_Hz;
    head["sourceAmplitude_Pa_m"] = sourceAmplitude_Pa_m;
    if (exposureAmplitude_Pa_m > 0.0) head["exposureAmplitude_Pa_m"] = exposureAmplitude_Pa_m;
    head["directivity"] = directivityName(directivity);
    head["ringing"] = ringing_s;
    head["phaseLevels"] = drive.phaseLevels;
    head["amplitudeLevels"] = drive.amplitudeLevels;
    if (!dead.empty()) head["dead"] = dead;

    std::string text = "{\n";
    for (const auto& item : head.items())
        text += fmt::format("  \"{}\": {},\n",
                            item.key(),
                            item.value().dump(-1, ' ', false, Json::error_handler_t::replace));
    text += "  \"transducers\": [\n";
    for (Eigen::Index i = 0; i < positions.cols(); ++i)
    {
        Json item;
        item["position_m"] = {positions(0, i), positions(1, i), positions(2, i)};
        item["normal"] = {normals(0, i), normals(1, i), normals(2, i)};
        item["board"] = board[static_cast<std::size_t>(i)];
        if (phaseOffset_rad.size() > 0) item["phaseOffset_rad"] = phaseOffset_rad[i];
        if (gain.size() > 0) item["gain"] = gain[i];
        text += fmt::format("    {}{}\n", item.dump(), i + 1 < positions.cols() ? "," : "");
    }
    return text + "  ]\n}\n";
}

} // namespace midair::haptics
