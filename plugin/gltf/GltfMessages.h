#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

namespace osgMidair
{

/// A glTF file that isn't read; what() says what is wrong and what would be right.
class GltfError : public std::runtime_error
{
public:
    using std::runtime_error::runtime_error;
};

/// What is told of one file, each once, up to kMost: what concerns how it is felt, and what is only
/// drawn in another way.
class GltfMessages
{
public:
    static constexpr std::size_t kMost = 20;

    void say(const std::string& message) { add(_all, message); }
    void sayOfPicture(const std::string& message) { add(_ofPicture, message); }
    /// For what might have made it quieter, and isn't followed.
    void sayUnfollowed(const std::string& message)
    {
        say(message);
        add(_unfollowed, message);
    }
    /// What the extras of its scene say of a HapticScene, as assignments.
    void addSetting(const std::string& assignment) { _settings += assignment + "\n"; }
    const std::vector<std::string>& all() const { return _all; }
    const std::vector<std::string>& ofPicture() const { return _ofPicture; }
    const std::vector<std::string>& unfollowed() const { return _unfollowed; }
    const std::string& settings() const { return _settings; }

private:
    static void add(std::vector<std::string>& to, const std::string& message)
    {
        if (to.size() < kMost && std::find(to.begin(), to.end(), message) == to.end())
            to.push_back(message);
    }

    std::vector<std::string> _all;
    std::vector<std::string> _ofPicture;
    std::vector<std::string> _unfollowed;
    std::string _settings;
};

} // namespace osgMidair
