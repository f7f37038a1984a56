#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace midair::samples
{

/// The models in a folder, one after the other and over and over. Files that come and go are seen
/// at the beginning of each round; one that can't be shown is passed over from then on, unless it
/// changes.
class ModelFolder
{
public:
    /// Throws std::runtime_error if \a folder is none or has no model.
    explicit ModelFolder(std::filesystem::path folder);

    /// Returns the path of the next model; empty if there is none now, and problem() says why.
    std::string next();
    /// Leaves a model out.
    void skip(const std::string& path, const std::string& reason);

    const std::string& problem() const { return _problem; }
    const std::map<std::string, std::string>& skipped() const { return _skipped; } ///< by name
    /// Names of files that are no models, such as textures beside them.
    const std::vector<std::string>& others() const { return _others; }
    int rounds() const { return _rounds; }

private:
    void look();

    std::filesystem::path _folder;
    std::vector<std::string> _paths;
    std::vector<std::string> _others;
    std::string _problem; ///< why _paths is empty
    std::size_t _next = 0;
    int _rounds = 0; ///< that were begun
    std::map<std::string, std::string> _skipped;
    std::map<std::string, std::filesystem::file_time_type> _changed; ///< of what is left out
};

} // namespace midair::samples
