#pragma once

#include "haptics/base/text/MessageLog.h"
#include "haptics/base/threads/Mutex.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace midair::bridge
{

/// What the user is told about one scene: each message once, counted, and as lines of a log that
/// stays readable.
class SceneMessages
{
public:
    using Line = base::LineLimit::Line;

    /// \a print: takes each line on the thread that says it; none: messages are kept alone.
    explicit SceneMessages(std::function<void(const Line&)> print) : _print(std::move(print)) {}

    /// Adds \a message, or counts it if it is there. For one thread at a time, as the next two.
    void say(base::Message message) { keep(std::move(message), true); }
    /// Takes over those of \a told that are new since the last call, which the hologram thread has
    /// counted.
    void take(const std::vector<base::Message>& told);
    /// Takes over one that something else than that thread has counted.
    void adopt(const base::Message& message) { keep(message, false); }
    /// Prints lines that have waited until \a now_s.
    void printDue(double now_s);

    /// All so far. Any thread.
    std::vector<base::Message> all() const;

private:
    void keep(base::Message message, bool isCounted);

    const std::function<void(const Line&)> _print;
    base::LineLimit _lines;
    std::uint64_t _takenUpTo = 0; ///< newest Message::said of those that were taken
    mutable base::Mutex _mutex;
    base::MessageLog _log MIDAIR_GUARDED_BY(_mutex);
};

} // namespace midair::bridge
