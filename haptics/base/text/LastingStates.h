#pragma once

#include "haptics/base/text/MessageCode.h"

#include <cstdint>
#include <set>
#include <string>
#include <tuple>

namespace midair::base
{

/// Knows which states of objects have held since the last look, so that each is told when it begins
/// and not in every look.
class LastingStates
{
public:
    /// Begins a look at all objects.
    void begin() { _now.clear(); }

    /// Takes note of a state that holds; \a why tells those of one code apart. Returns true if it
    /// has just begun.
    bool note(MessageCode code, std::uint64_t object, const std::string& why = std::string())
    {
        const State state(code, object, why);
        return _now.insert(state).second && _before.count(state) == 0;
    }

    /// Lets a state that has been noted go on, whether it holds or not.
    void keep(MessageCode code, std::uint64_t object, const std::string& why)
    {
        const State state(code, object, why);
        if (_before.count(state) > 0) _now.insert(state);
    }

    /// Ends a look: what was not noted in it has ended. One that is broken off changes nothing.
    void end() { _before.swap(_now); }

private:
    using State = std::tuple<MessageCode, std::uint64_t, std::string>;

    std::set<State> _before;
    std::set<State> _now;
};

} // namespace midair::base
