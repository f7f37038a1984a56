#pragma once

#include "haptics/base/InputError.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
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
    NOTICE,  ///< something differs from what users may expect
    WARNING, ///< something is left out, or not done as requested
    FAULT    ///< nothing is played
};

/// Subject of a message. Every message has a code; MESSAGES.md has a row for each.
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
    DISPLAY_HEAD,
    DISPLAY_VIEW,
    FIELD_FAILED,
    FIELD_FAINT,
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
    REFLECTOR_INVALID,
    REFLECTOR_LIMITED,
    REFLECTOR_SOLVED,
    SCENE_CLOSED,
    SCENE_EMPTY,
    SCENE_INCOMPLETE,
    SCENE_INSIDE,
    SCENE_LIMIT,
    SCENE_UNMARKED,
    SENSATION_LIMITED,
    SETTINGS_CALIBRATION,
    SETTINGS_INVALID,
    SETTINGS_LIMITED,
    SETTINGS_SILENCED,
    SOLVER_REFUSED,
    SOLVER_REPORT,
    SOLVER_SLOW,
    SOLVER_UNKNOWN,
    VIEWER_SILENT
};

/// How long a message stays active.
enum class Lasts
{
    MOMENT, ///< an event; active only as long as its Topic, if it has one
    FIELD,  ///< until a field is made without repeating the message
    STATE   ///< until its sender ends it
};

/// Row of the table of codes.
struct MessageKind
{
    MessageCode code;
    const char* name; ///< for programs, "device.lost"; stable across versions
    Severity severity;
    Lasts lasts;
    /// True: all messages with this code and path are one, whatever their texts. False: only texts
    /// that differ in numbers alone are.
    bool isOne;
};

/// All codes, one row each.
const std::vector<MessageKind>& messageKinds();
const MessageKind& kindOf(MessageCode code);

/// Returns "notice", "warning" or "fault".
std::string severityName(Severity severity);

/// Input error that becomes a message with the code \a code.
class CodedError : public InputError
{
public:
    CodedError(MessageCode itsCode, const std::string& what) : InputError(what), code(itsCode) {}

    const MessageCode code;
};

/// A message for the user. Messages about the same thing at the same node are merged and counted,
/// even if numbers in their texts differ.
struct Message
{
    /// \a path: of the node it is about, or empty. The text begins with it.
    Message(MessageCode itsCode, std::string itsText, std::string itsPath = std::string()) :
        code(itsCode),
        path(std::move(itsPath)),
        text(std::move(itsText))
    {
    }

    MessageCode code;
    std::string path;
    std::string text; ///< the newest text
    std::uint64_t count = 1;
    std::shared_ptr<const void> origin; ///< origin of the object it is about; null: none
    /// Increases with each message sent in this program; 0: not in a log
    std::uint64_t said = 0;
    std::uint64_t number = 0;  ///< unique within its log
    std::uint64_t changed = 0; ///< like number, and raised again when the message ends
    bool isActive = false;     ///< what it says is still true
    double since_s = 0.0;      ///< steady clock; first sent, or last became active
    double until_s = 0.0;      ///< time of its end; 0: active, or an event

    Severity severity() const { return kindOf(code).severity; }
};

/// A message about the node at \a path: "PATH: TEXT". \a origin: as HapticObject::origin.
inline Message about(MessageCode code,
                     const std::string& path,
                     const std::string& text,
                     std::shared_ptr<const void> origin = nullptr)
{
    Message message{code, path + ": " + text, path};
    message.origin = std::move(origin);
    return message;
}

/// Returns \a text with each number outside quotes replaced by #.
std::string withoutNumbers(const std::string& text);

/// Key of a state. A log uses it to recognise states that it has already reported.
struct Topic
{
    MessageCode code;
    std::uint64_t object = 0; ///< object of the state; 0: none
    std::string why = {};     ///< distinguishes states of the same code and object

    bool operator<(const Topic& other) const
    {
        return std::tie(code, object, why) < std::tie(other.code, other.object, other.why);
    }
};

/// All messages for the user. Each message is listed once, with a count, in order of first
/// occurrence. A lasting state is reported when it begins, and again when it returns after it
/// ended. Printed lines are rate-limited. A message is active from when it is sent until its state
/// ends (Lasts). Any thread.
///
/// Of each code and path the kMostAlike newest texts stay. Above kMost messages one is evicted, in
/// order: non-faults, duplicates of a code and path, the least severe, those of the most frequent
/// code, the oldest. A non-fault never evicts another message.
class MessageLog
{
public:
    /// limit, so that a scene full of errors doesn't fill the memory
    static constexpr std::size_t kMost = 100;
    static constexpr std::size_t kMostAlike = 8; ///< texts of one code and path
    static constexpr int kFirstLines = 8; ///< lines of one code and path that are printed at once
    static constexpr double kLinePause_s = 1.0; ///< pause between later lines

    struct Line
    {
        Severity severity;
        std::string text;
    };
    /// Receives each line, on the sender's thread.
    using Print = std::function<void(const Line&)>;

    /// A log whose messages another log takes over.
    MessageLog() = default;
    /// The user's log, which makes all text printable. \a print: receives a line for each new
    /// message; after kFirstLines of one code and path at most one per kLinePause_s, the newest,
    /// with the number of lines left out before it. None: messages are only stored.
    explicit MessageLog(Print print, const Clock& clock = steadyClock()) :
        _clock(clock),
        _print(std::move(print)),
        _isForUser(true)
    {
    }

    /// Adds a message; if it exists, counts it and updates its text. A message that replaces
    /// another of its code and path continues its count. Returns true if it is new.
    bool say(Message message) { return keep(std::move(message), true); }
    /// Takes over a message from another log with its count: keeps the larger count and the newer
    /// text. Returns true if it is new.
    bool take(const Message& message) { return keep(message, message.said == 0); }
    /// Takes over the messages in \a all, the content of the only other log, that are new since the
    /// last call. Ends messages taken earlier that are no longer active there.
    void takeNew(const std::vector<Message>& all);
    /// Prints delayed lines that are due at \a now_s.
    void printDue(double now_s);

    /// \{ Lasting states.

    /// Returns true if \a topic has just begun: it \a holds now and did not before.
    bool begins(const Topic& topic, bool holds = true);
    /// Ends a topic and its messages.
    void ends(const Topic& topic) { begins(topic, false); }
    /// Ends all topics of \a object.
    void endsOf(std::uint64_t object);
    /// Sends a message of a topic that has begun or was noted.
    bool say(const Topic& topic, Message message);
    /// Sends one message for all \a topics, with the text of the first. It ends with the last of
    /// them.
    void sayOfAll(const std::vector<Topic>& topics, Message first);
    /// Replaces the messages of \a topic by \a all. Messages that were sent last time as well
    /// continue, uncounted.
    void sayNow(const Topic& topic, const std::vector<Message>& all);
    /// Ends all messages of a code except those of topics.
    void end(MessageCode code);
    /// Ends messages that last a field, except those sent after \a before, the value of saidNow()
    /// before the field was made.
    void endField(std::uint64_t before);
    static std::uint64_t saidNow();

    /// Begins a scan of all objects: noted states that are not noted again in this scan end with
    /// it. An interrupted scan changes nothing.
    void beginLook();
    /// Notes an active state. Returns true if it has just begun.
    bool note(const Topic& topic);
    /// Notes \a topic, and sends its message if it has just begun.
    void note(const Topic& topic, const Message& message)
    {
        if (note(topic)) say(topic, message);
    }
    /// Keeps a noted state active without checking it.
    void keepNoted(const Topic& topic);
    void endLook();
    /// \}

    std::vector<Message> messages() const;
    std::vector<std::string> all() const; ///< texts of all messages
    /// Increases whenever a message is sent or ends.
    std::uint64_t changes() const;
    /// Returns messages sent or ended since \a seen, which becomes changes().
    std::vector<Message> changedSince(std::uint64_t& seen) const;
    /// Removes all messages that are not active.
    void forgetEnded();
    /// Returns the texts of messages added after the first \a told, which becomes added().
    std::vector<std::string> newTexts(std::size_t& told) const;
    /// Returns the number of different messages so far, including removed ones.
    std::size_t added() const;

private:
    /// Lines of one code and path.
    struct Told
    {
        int lines = 0;
        double last_s = 0.0;       ///< time of the last line
        std::uint64_t waiting = 0; ///< messages since then
        std::string newest;        ///< text of the last of them
    };
    struct Lines
    {
        std::map<std::pair<MessageCode, std::string>, Told> of;
        std::uint64_t waiting = 0; ///< waiting messages of all
    };
    /// Topics with the keys of their messages.
    using Topics = std::map<Topic, std::vector<std::string>>;
    struct States
    {
        Topics lasting;      ///< begun, and not ended
        Topics noted;        ///< noted in the last scan
        Topics fresh;        ///< noted in this scan, and not in the last
        std::set<Topic> now; ///< all noted in this scan
    };
    /// State of takeNew().
    struct Taken
    {
        std::uint64_t said = 0;     ///< newest Message::said
        std::uint64_t changed = 0;  ///< newest Message::changed
        std::set<std::string> keys; ///< keys of the active messages
    };

    bool keep(Message message, bool isCounted);
    void makePrintable(Message& message) const;
    void link(const Topic& topic, const std::string& key) MIDAIR_REQUIRES(_mutex);
    static void renew(Message& known, Message message);
    void end(Message& message) MIDAIR_REQUIRES(_mutex);
    bool isHeld(const std::string& key) const MIDAIR_REQUIRES(_mutex);
    void endUnheld(const std::vector<std::string>& keys) MIDAIR_REQUIRES(_mutex);
    void erase(Topics& topics, const Topic& topic) MIDAIR_REQUIRES(_mutex);
    void takeEnds(const std::vector<Message>& all) MIDAIR_REQUIRES(_mutex);
    Message* find(const std::string& key) MIDAIR_REQUIRES(_mutex);
    void add(std::string key, Message message, bool isCounted) MIDAIR_REQUIRES(_mutex);
    bool makeRoom(const Message& message) MIDAIR_REQUIRES(_mutex);
    std::size_t leastOfAll() const MIDAIR_REQUIRES(_mutex);
    void erase(std::size_t i) MIDAIR_REQUIRES(_mutex);
    std::optional<Line> lineOf(const Message& message) MIDAIR_REQUIRES(_mutex);
    Line lineOf(MessageCode code, Told& told, double now_s) MIDAIR_REQUIRES(_mutex);

    const Clock& _clock = steadyClock();
    const Print _print;
    const bool _isForUser = false;
    mutable Mutex _mutex;
    std::vector<Message> _all MIDAIR_GUARDED_BY(_mutex);
    std::vector<std::string> _keys MIDAIR_GUARDED_BY(_mutex); ///< key of each message
    std::size_t _added MIDAIR_GUARDED_BY(_mutex) = 0;
    Taken _taken MIDAIR_GUARDED_BY(_mutex);
    Lines _lines MIDAIR_GUARDED_BY(_mutex);
    States _states MIDAIR_GUARDED_BY(_mutex);
};

} // namespace midair::base
