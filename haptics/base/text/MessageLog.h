#pragma once

#include <string>
#include <unordered_set>
#include <vector>

namespace midair::base
{

/// What the user should know, each said once, in the order in which it came up.
class MessageLog
{
public:
    /// a scene that is wrong everywhere doesn't fill the memory
    static constexpr std::size_t kMost = 100;

    /// False when it was said before (or too much was said already).
    bool say(const std::string& message)
    {
        if (_all.size() >= kMost || !_said.insert(message).second) return false;
        _all.push_back(message);
        return true;
    }

    const std::vector<std::string>& all() const { return _all; }

private:
    std::vector<std::string> _all;
    std::unordered_set<std::string> _said;
};

} // namespace midair::base
