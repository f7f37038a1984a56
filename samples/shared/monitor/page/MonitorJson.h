#pragma once

#include "samples/shared/monitor/page/MonitorWatch.h"

#include <array>
#include <string>

namespace midair::samples
{

/// By HapticMessage::Severity.
inline constexpr std::array kSeverityNames = {"notice", "warning", "fault"};

/// Counts of the page itself, for itself and for Prometheus.
struct PageCounts
{
    std::map<int, std::uint64_t> answers; ///< by HTTP status
};

/// What is shown, at one moment.
struct MonitorState
{
    std::string name;   ///< of the program and what it shows
    double now_s = 0.0; ///< steady clock
    MonitorView view;
    PictureCost picture;
    PageCounts page;

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

} // namespace midair::samples
