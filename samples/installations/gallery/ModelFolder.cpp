#include "samples/installations/gallery/ModelFolder.h"

#include <osgDB/FileNameUtils>
#include <osgDB/Registry>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace midair::samples
{

namespace
{

namespace fs = std::filesystem;

/// What lies beside models: materials, buffers, pictures, texts.
bool isBeside(const std::string& extension)
{
    static const std::set<std::string> kBeside = {"mtl",
                                                  "bin",
                                                  "png",
                                                  "jpg",
                                                  "jpeg",
                                                  "tga",
                                                  "bmp",
                                                  "gif",
                                                  "tif",
                                                  "tiff",
                                                  "dds",
                                                  "hdr",
                                                  "rgb",
                                                  "txt",
                                                  "md",
                                                  "csv",
                                                  "json"};
    return kBeside.count(extension) > 0;
}

/// True if OpenSceneGraph has a plugin for \a path. Its content may be something else all the same.
bool isModel(const fs::path& path)
{
    const std::string extension = osgDB::getLowerCaseFileExtension(path.string());
    return !extension.empty() && !isBeside(extension) &&
           osgDB::Registry::instance()->getReaderWriterForExtension(extension);
}

} // namespace

ModelFolder::ModelFolder(fs::path folder) : _folder(std::move(folder))
{
    look();
    if (!_problem.empty()) throw std::runtime_error(_problem);
    if (_paths.empty())
        throw std::runtime_error("there is no model in the folder \"" + _folder.string() + "\"");
}

void ModelFolder::look()
{
    std::error_code error;
    std::vector<std::string> paths;
    std::vector<std::string> others;
    for (const fs::directory_entry& entry : fs::directory_iterator(_folder, error))
    {
        std::error_code ignored;
        if (entry.is_directory(ignored)) continue;
        // A link to nothing or a pipe is no model, whatever its name.
        const bool isShown = entry.is_regular_file(ignored) && isModel(entry.path());
        (isShown ? paths : others).push_back(entry.path().string());
    }
    _problem = error ? "can't read the folder \"" + _folder.string() + "\": " + error.message()
                     : std::string();
    std::sort(paths.begin(), paths.end());
    _others.clear();
    for (const std::string& other : others)
        _others.push_back(osgDB::getSimpleFileName(other));
    std::sort(_others.begin(), _others.end());
    const auto isLeftOut = [&](const std::string& path)
    {
        const auto left = _changed.find(path);
        if (left == _changed.end() || fs::last_write_time(path, error) == left->second)
            return left != _changed.end();
        _skipped.erase(osgDB::getSimpleFileName(path));
        _changed.erase(left);
        return false;
    };
    paths.erase(std::remove_if(paths.begin(), paths.end(), isLeftOut), paths.end());
    _paths = std::move(paths);
    _next = 0;
}

std::string ModelFolder::next()
{
    if (_next >= _paths.size()) look();
    if (_paths.empty() && _problem.empty())
        _problem = "of the models in \"" + _folder.string() + "\" none can be felt";
    if (_paths.empty()) return {};
    if (_next == 0) ++_rounds;
    return _paths[_next++];
}

void ModelFolder::skip(const std::string& path, const std::string& reason)
{
    std::error_code ignored;
    _changed[path] = fs::last_write_time(path, ignored);
    _skipped[osgDB::getSimpleFileName(path)] = reason;
}

} // namespace midair::samples
