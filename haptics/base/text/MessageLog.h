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
    NOTICE,  ///< something is done otherwise than one may think
    WARNING, ///< something is left out, or not done as it was asked for
    FAULT    ///< nothing is played
};

/// What a message is about. There is no message without; MESSAGES.md has a line for each.
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
    SOLVER_UNKNOWN,
    VIEWER_SILENT
};

/// How long what a message says holds.
enum class Lasts
{
    MOMENT, ///< it has happened; it is active only where it is said of a Topic
    FIELD,  ///< until a field is made of which it isn't said
    STATE   ///< until who has said it ends it
};

/// A row of the table of codes.
struct MessageKind
{
    MessageCode code;
    const char* name; ///< for programs, "device.lost"; it stays from version to version
    Severity severity;
    Lasts lasts;
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
    std::shared_ptr<const void> origin; ///< as of the object that it is about; null: none
    /// Rises with each message that a log of this program is told; 0: no log has it.
    std::uint64_t said = 0;
    std::uint64_t number = 0;  ///< in the log that has it; never given twice
    std::uint64_t changed = 0; ///< the same, and with each that ends
    bool isActive = false;     ///< what it says holds
    double since_s = 0.0;      ///< steady clock; when it was said first, or began to hold last
    double until_s = 0.0;      ///< when it ended; 0: it is active, or was of a moment

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

/// \a text with each number outside of quotes replaced by #.
std::string withoutNumbers(const std::string& text);

/// What is told of: by this key a log knows what it has told already.
struct Topic
{
    MessageCode code;
    std::uint64_t object = 0; ///< that it is told of; 0: of none
    std::string why = {};     ///< tells those of one code and object apart

    bool operator<(const Topic& other) const
    {
        return std::tie(code, object, why) < std::tie(other.code, other.object, other.why);
    }
};

/// All that is said to a user, by its key: each message once and counted, in the order of their
/// first occurrence; a state that lasts when it begins, and again when it has ended and come back;
/// lines no faster than they can be read. A message is active from when it is said until what it
/// says has ended (Lasts). Any thread.
///
/// Of one code and path the kMostAlike newest texts stay. If there are more than kMost messages,
/// one goes: what is no fault before what is one; of those what has others of its code and path
/// beside it, then what is least severe, then that of which code there are most; of equal ones what
/// was said longest ago. A message that is no fault takes the place of none.
class MessageLog
{
public:
    /// limit, so that a scene full of errors doesn't fill the memory
    static constexpr std::size_t kMost = 100;
    static constexpr std::size_t kMostAlike = 8; ///< texts of one code and path
    static constexpr int kFirstLines = 8;        ///< of one code and path, each printed at once
    static constexpr double kLinePause_s = 1.0;  ///< between two of those that follow

    struct Line
    {
        Severity severity;
        std::string text;
    };
    /// Takes each line on the thread that says it.
    using Print = std::function<void(const Line&)>;

    /// A log whose messages another one takes over.
    MessageLog() = default;
    /// The log of a user, who sees printable text alone. \a print: gets a line for each new
    /// message; after kFirstLines of one code and path at most one in kLinePause_s, the newest,
    /// which says how many were left out before it. None: messages are kept alone.
    explicit MessageLog(Print print, const Clock& clock = steadyClock()) :
        _clock(clock),
        _print(std::move(print)),
        _isForUser(true)
    {
    }

    /// Adds a message, or counts it if it is there and takes over its text. One that takes the
    /// place of another of its code and path goes on with that one's count. Returns true if it is
    /// new.
    bool say(Message message) { return keep(std::move(message), true); }
    /// Takes over a message of another log, which counts it: the larger count stays, and the newer
    /// text. Returns true if it is new.
    bool take(const Message& message) { return keep(message, message.said == 0); }
    /// Takes over those of \a all, the messages of the one other log there is now, that are new
    /// since the last call. Of those taken before, what isn't active there has ended.
    void takeNew(const std::vector<Message>& all);
    /// Prints lines that have waited until \a now_s.
    void printDue(double now_s);

    /// \{ States that last.

    /// Returns true if \a topic has just begun to hold: it \a holds, and has not since it was begun
    /// or ended last.
    bool begins(const Topic& topic, bool holds = true);
    /// With the topic end the messages that were said of it.
    void ends(const Topic& topic) { begins(topic, false); }
    /// Ends all topics of \a object.
    void endsOf(std::uint64_t object);
    /// Says a message of a topic that has begun, or was noted.
    bool say(const Topic& topic, Message message);
    /// Says of all \a topics what \a first says of the first of them: one message, however many
    /// they are, which ends with the last of them.
    void sayOfAll(const std::vector<Topic>& topics, Message first);
    /// Says that of \a topic \a all holds, and nothing else any more. What was said of it last time
    /// as well goes on, uncounted.
    void sayNow(const Topic& topic, const std::vector<Message>& all);
    /// Ends all messages of a code, but for those that topics hold.
    void end(MessageCode code);
    /// A field has been made: those that last a field have ended, but for those said after
    /// \a before, which is what saidNow() returned before the field.
    void endField(std::uint64_t before);
    static std::uint64_t saidNow();

    /// Begins a look at all objects: of states that were noted in looks, those that are not noted
    /// in this one end with it. A look that is broken off changes nothing.
    void beginLook();
    /// Takes note of a state that holds. Returns true if it has just begun.
    bool note(const Topic& topic);
    /// Notes \a topic, and says its message if it has just begun.
    void note(const Topic& topic, const Message& message)
    {
        if (note(topic)) say(topic, message);
    }
    /// Lets a state that has been noted go on, whether it holds or not.
    void keepNoted(const Topic& topic);
    void endLook();
    /// \}

    std::vector<Message> messages() const;
    std::vector<std::string> all() const; ///< their texts
    /// Rises whenever a message is said or ends.
    std::uint64_t changes() const;
    /// Those that were said or have ended since \a seen, which becomes changes().
    std::vector<Message> changedSince(std::uint64_t& seen) const;
    /// Forgets all messages that are not active.
    void forgetEnded();
    /// Texts of those that were added after the first \a told, which becomes added().
    std::vector<std::string> newTexts(std::size_t& told) const;
    /// How many different messages there were so far, those that are gone included.
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
        std::uint64_t waiting = 0; ///< messages of all
    };
    /// Topics with the keys of what was said of them.
    using Topics = std::map<Topic, std::vector<std::string>>;
    struct States
    {
        Topics lasting;      ///< begun, and not ended
        Topics noted;        ///< in the last look
        Topics fresh;        ///< in this one, and not in the last
        std::set<Topic> now; ///< all that are noted in this one
    };
    /// What takeNew() has taken.
    struct Taken
    {
        std::uint64_t said = 0;     ///< newest Message::said
        std::uint64_t changed = 0;  ///< newest Message::changed
        std::set<std::string> keys; ///< of those that were active
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
    std::vector<std::string> _keys MIDAIR_GUARDED_BY(_mutex); ///< of each
    std::size_t _added MIDAIR_GUARDED_BY(_mutex) = 0;
    Taken _taken MIDAIR_GUARDED_BY(_mutex);
    Lines _lines MIDAIR_GUARDED_BY(_mutex);
    States _states MIDAIR_GUARDED_BY(_mutex);
};

} // namespace midair::base
