#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace osgMidair
{

/// What is told of one file, each once, up to kMost.
class GltfMessages
{
public:
    static constexpr std::size_t kMost = 20;

    void say(const std::string& message)
    {
        if (_all.size() < kMost && std::find(_all.begin(), _all.end(), message) == _all.end())
            _all.push_back(message);
    }
    const std::vector<std::string>& all() const { return _all; }

private:
    std::vector<std::string> _all;
};

} // namespace osgMidair
