#pragma once

#include "haptics/base/text/MessageCode.h"

#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace midair::base
{

/// A message for the user. Those of one thing at one node are one message, whatever the numbers in
/// their texts, and are counted.
struct Message
{
    /// \a path: of the node that it is about; none: it is about none. The text begins with it.
    Message(MessageCode itsCode, std::string itsText, std::string itsPath = std::string()) :
        code(itsCode),
        path(std::move(itsPath)),
        text(std::move(itsText))
    {
    }

    MessageCode code;
    std::string path;
    std::string text; ///< the newest
    std::uint64_t count = 1;
    /// Rises with each message that a log of this program is told; 0: no log has it.
    std::uint64_t said = 0;

    Severity severity() const { return kindOf(code).severity; }
};

/// A message about the node at \a path: "PATH: TEXT".
inline Message about(MessageCode code, const std::string& path, const std::string& text)
{
    return {code, path + ": " + text, path};
}

/// \a text with each number outside of quotes replaced by #.
std::string withoutNumbers(const std::string& text);

/// Messages for the user, each once, in the order of their first occurrence. Of one code and path
/// the kMostAlike newest texts stay. If there are more than kMost messages, one goes: what is no
/// fault before what is one; of those what has others of its code and path beside it, then what is
/// least severe, then that of which code there are most; of equal ones what was said longest ago. A
/// message that is no fault takes the place of none.
class MessageLog
{
public:
    /// limit, so that a scene full of errors doesn't fill the memory
    static constexpr std::size_t kMost = 100;
    static constexpr std::size_t kMostAlike = 8; ///< texts of one code and path

    /// Adds a message, or counts it if it is there and takes over its text. One that takes the
    /// place of another of its code and path goes on with that one's count. Returns true if it is
    /// new.
    bool say(Message message);
    /// Takes over a message of another log, which counts it: the larger count stays, and the newer
    /// text. Returns true if it is new.
    bool take(const Message& message);

    const std::vector<Message>& messages() const { return _all; }
    std::vector<std::string> all() const; ///< their texts
    /// How many different messages there were so far, those that are gone included.
    std::size_t added() const { return _added; }

private:
    Message* find(const std::string& key);
    void add(std::string key, Message message, bool isCounted);
    bool makeRoom(const Message& message);
    std::size_t leastOfAll() const;
    void erase(std::size_t i);

    std::vector<Message> _all;
    std::vector<std::string> _keys; ///< of each
    std::size_t _added = 0;
};

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
