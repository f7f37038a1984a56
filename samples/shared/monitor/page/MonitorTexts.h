#pragma once

#include "samples/shared/monitor/page/MonitorWatch.h"

#include <cstdint>
#include <map>
#include <string>

namespace midair::samples
{

/// What is shown, at one moment.
struct MonitorState
{
    std::string name;   ///< of the program and what it shows
    double now_s = 0.0; ///< steady clock
    MonitorView view;
    PictureCost picture;
    std::map<int, std::uint64_t> answers; ///< of the page itself, by HTTP status

    bool isOld() const { return !view.isRead || now_s - view.read_s > MonitorWatch::kOld_s; }
    /// True: the program doesn't draw or update its scene.
    bool isStanding() const { return now_s - view.frame_s > MonitorWatch::kOld_s; }
};

/// Returns all of it as JSON. Texts may be any bytes: what is no UTF-8 is replaced. While a reading
/// is old, what it said is left out: "array" and the rest are null.
std::string statusJson(const MonitorState& state);

/// Returns what a mute came to as JSON.
std::string muteJson(bool muted, const MuteOutcome& outcome);

/// Returns an empty text while all is well, or why it isn't: nothing is read, the frame loop
/// stands still, or the array is closed, lost or faulty. A muted array is well.
std::string healthProblem(const MonitorState& state);

/// Returns what is known as Prometheus reads it (text exposition format 0.0.4). While a reading is
/// old there are only midair_up 0, ages and what the page counts: Prometheus then shows that the
/// rest isn't known.
std::string metricsText(const MonitorState& state);

/// Returns \a text within the quotes of a label: valid UTF-8 in one line.
std::string labelValue(std::string text);

} // namespace midair::samples
