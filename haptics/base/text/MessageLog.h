#pragma once

#include "haptics/base/InputError.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace midair::base
{

enum class Severity
{
    NOTICE,  ///< something is done otherwise than one may think
    WARNING, ///< something is left out, or not done as it was asked for
    FAULT    ///< nothing is played
};

/// What a message is about. There is no message without; plugin/MESSAGES.md has a line for each.
enum class MessageCode
{
    AIR_TEMPERATURE,
    ARRAY_DEAD,
    ARRAY_INVALID,
    ARRAY_READ_AGAIN,
    ARRAY_REFUSED,
    CALLBACK_THREW,
    CAP_EARS,
    CAP_PRESSURE,
    DEVICE_CAP,
    DEVICE_FAULT,
    DEVICE_HANGS,
    DEVICE_LOST,
    DEVICE_MUTED,
    DEVICE_OPEN,
    DEVICE_OPENED,
    DEVICE_REFUSED,
    DEVICE_SLOW,
    FIELD_FAILED,
    FIELD_REST,
    FIELD_SILENCED,
    FIELD_UNEVEN,
    GRANTS_FILE,
    GRANTS_REFUSED,
    GRANTS_TRUST,
    HANDS_OPEN,
    HANDS_PREDICTION,
    HANDS_SOURCE,
    HANDS_THREW,
    MODULATION_FREQUENCY,
    MODULATION_OVERRIDDEN,
    MODULATION_SUBSETS,
    MONITOR_FAILED,
    OBJECT_CAMERA,
    OBJECT_GEOMETRY,
    OBJECT_HIDDEN,
    OBJECT_INVALID,
    OBJECT_LARGE,
    OBJECT_SIDE,
    OBJECT_SMALL,
    OBJECT_UNFELT,
    OBJECT_UNITS,
    OBJECT_UNREACHABLE,
    OBJECT_UNTURNED,
    OBSTACLE_IDLE,
    OBSTACLE_INVALID,
    POINTS_BUDGET,
    POINTS_INVALID,
    PROPERTY_INVALID,
    PROPERTY_SILENCED,
    SCENE_CLOSED,
    SCENE_EMPTY,
    SCENE_INCOMPLETE,
    SCENE_INSIDE,
    SCENE_LIMIT,
    SCENE_UNMARKED,
    SETTINGS_CALIBRATION,
    SETTINGS_INVALID,
    SETTINGS_LIMITED,
    SETTINGS_SILENCED,
    SOLVER_REFUSED,
    SOLVER_REPORT,
    SOLVER_SLOW,
    VIEWER_SILENT
};

/// A row of the table of codes.
struct MessageKind
{
    MessageCode code;
    const char* name; ///< for programs, "device.lost"; it stays from version to version
    Severity severity;
    /// True: all messages with this code and path are one, whatever their texts; else those that
    /// differ in numbers alone.
    bool isOne;
};

/// All codes, one row each.
const std::vector<MessageKind>& messageKinds();
const MessageKind& kindOf(MessageCode code);

/// "notice", "warning" or "fault".
std::string severityName(Severity severity);

/// Input error that becomes a message of the code \a code.
class CodedError : public InputError
{
public:
    CodedError(MessageCode itsCode, const std::string& what) : InputError(what), code(itsCode) {}

    const MessageCode code;
};

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

/// Keeps a log that is read line by line readable: of messages of one code and path the first
/// kFirst are lines at once; after those there is at most one line in kPause_s, the newest, which
/// says how many were left out before it. One thread at a time.
class LineLimit
{
public:
    static constexpr int kFirst = 8;
    static constexpr double kPause_s = 1.0;

    struct Line
    {
        Severity severity;
        std::string text;
    };

    /// Returns the line of \a message, which is new at \a time_s (any clock that doesn't go back);
    /// none: it waits for due().
    std::optional<Line> take(const Message& message, double time_s);

    /// Returns the lines that have waited until \a time_s.
    std::vector<Line> due(double time_s);

private:
    using Place = std::pair<MessageCode, std::string>; ///< code and path

    struct Told
    {
        int lines = 0;
        double last_s = 0.0;       ///< time of the last line
        std::uint64_t waiting = 0; ///< messages since then
        std::string newest;        ///< text of the last of them
    };

    static Line lineOf(MessageCode code, Told& told, double time_s);

    std::map<Place, Told> _told;
    std::uint64_t _waiting = 0; ///< messages in all places
};

} // namespace midair::base
