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
    const std::vector<std::string>& all() const { return _all; }
    const std::vector<std::string>& ofPicture() const { return _ofPicture; }

private:
    static void add(std::vector<std::string>& to, const std::string& message)
    {
        if (to.size() < kMost && std::find(to.begin(), to.end(), message) == to.end())
            to.push_back(message);
    }

    std::vector<std::string> _all;
    std::vector<std::string> _ofPicture;
};

} // namespace osgMidair
