#pragma once

#include "haptics/base/text/MessageCode.h"

#include <cstddef>
#include <cstdint>
#include <string>
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

    Severity severity() const { return kindOf(code).severity; }
};

/// A message about the node at \a path: "PATH: TEXT".
inline Message about(MessageCode code, const std::string& path, const std::string& text)
{
    return {code, path + ": " + text, path};
}

/// \a text with each number outside of quotes replaced by #.
std::string withoutNumbers(const std::string& text);

/// Messages for the user, each once, in the order of their first occurrence. If there are more than
/// kMost, the oldest of the least severity goes, so that a new one is always told.
class MessageLog
{
public:
    /// limit, so that a scene full of errors doesn't fill the memory
    static constexpr std::size_t kMost = 100;

    /// Adds a message, or counts it if it is there and takes over its text. Returns true if it is
    /// new.
    bool say(Message message);
    /// Takes over a message of another log, which counts it: the larger count stays. Returns true
    /// if it is new.
    bool take(const Message& message);

    const std::vector<Message>& messages() const { return _all; }
    std::vector<std::string> all() const; ///< their texts
    /// How many different messages there were so far, those that are gone included.
    std::size_t added() const { return _added; }

private:
    Message* find(const std::string& key);
    void add(std::string key, Message message);

    std::vector<Message> _all;
    std::vector<std::string> _keys; ///< of each
    std::size_t _added = 0;
};

} // namespace midair::base
