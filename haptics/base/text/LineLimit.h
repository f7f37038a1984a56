#pragma once

#include "haptics/base/text/MessageLog.h"

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace midair::base
{

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
