#pragma once

#include "samples/shared/monitor/page/MonitorWatch.h"

#include <cstdint>
#include <map>
#include <string>

namespace midair::samples
{

/// A snapshot of everything that the page shows.
struct MonitorState
{
    std::string name;   ///< the program and what it shows
    double now_s = 0.0; ///< steady clock
    MonitorView view;
    PictureCost picture;
    std::map<int, std::uint64_t> answers; ///< the page's own answers by HTTP status

    bool isOld() const { return !view.isRead || now_s - view.read_s > MonitorWatch::kOld_s; }
    /// Returns true if the program has stopped drawing or updating its scene.
    bool isStanding() const { return now_s - view.frame_s > MonitorWatch::kOld_s; }
};

/// Returns the state as JSON. Invalid UTF-8 in texts is replaced. While the reading is old, its
/// parts ("array" etc.) are null.
std::string statusJson(const MonitorState& state);

/// Returns the result of a mute as JSON.
std::string muteJson(bool muted, const MuteOutcome& outcome);

/// Returns an empty text if all is well, else the problem: no reading, a stopped frame loop, or a
/// closed, lost or faulty array. A muted array is well.
std::string healthProblem(const MonitorState& state);

/// Returns the state for Prometheus (text exposition format 0.0.4). While the reading is old there
/// are only midair_up 0, ages and the page's own counters, so that Prometheus shows the rest as
/// unknown.
std::string metricsText(const MonitorState& state);

/// Returns \a text for a quoted label: valid UTF-8 in one line.
std::string labelValue(std::string text);

} // namespace midair::samples
