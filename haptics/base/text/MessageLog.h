#pragma once

#include <string>
#include <unordered_set>
#include <vector>

namespace midair::base
{

/// Messages for the user, each once, in the order of their first occurrence.
class MessageLog
{
public:
    /// limit, so that a scene full of errors doesn't fill the memory
    static constexpr std::size_t kMost = 100;

    /// Adds a message. Returns false if it is already there or the log is full.
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
