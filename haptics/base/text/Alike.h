#pragma once

#include "haptics/base/text/MessageLog.h"

#include <cstddef>
#include <string>

namespace midair::base
{

/// Objects that one thing is said of: one message, however many they are.
class Alike
{
public:
    void add(const std::string& path)
    {
        if (_count++ == 0) _first = path;
    }
    void tell(MessageCode code, const std::string& what, MessageLog& messages) const
    {
        if (_count == 0) return;
        const std::string more =
            _count > 1 ? "; so it is with " + std::to_string(_count - 1) + " more" : "";
        messages.say(about(code, _first, what + more));
    }

private:
    std::size_t _count = 0;
    std::string _first; ///< path
};

} // namespace midair::base
