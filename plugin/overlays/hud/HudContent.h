#pragma once

#include "engine-bridge/pipeline/HologramResult.h"

#include <osgMidair/HapticStatistics>

#include <string>
#include <utility>
#include <vector>

namespace osgMidair
{

/// What the figures know of an array besides its newest field.
struct ArrayNews
{
    HapticStatistics statistics;
    bool isMuted = false;
    bool isEnabled = true; ///< false: the scene is disabled
};

/// What is said in large letters: one word, and why. Both empty: all is as it should be.
struct HudAlarm
{
    std::string word;
    std::string reason;
    /// True: nothing is felt although something should be; false: less than was asked for.
    bool isSilence = true;

    bool operator==(const HudAlarm& other) const
    {
        return word == other.word && reason == other.reason && isSilence == other.isSilence;
    }
};

/// Rates that only overlays know; 0: not shown.
struct OverlayRates
{
    double slices = 0.0; ///< 1/s, as the others
    double volumes = 0.0;
    double frames = 0.0;
};

using HudRows = std::vector<std::pair<std::string, std::string>>;

/// Returns what a scene without an owner tells: what \a result says by itself.
ArrayNews newsOf(const midair::bridge::HologramResult& result);

/// Returns MUTED, LOST, FAULT, SILENT or CAPPED with its reason. \a result may be null.
HudAlarm alarmOf(const ArrayNews& news, const midair::bridge::HologramResult* result);

/// Returns the figures by name, the most important first: where there is little room, only the
/// first ones are shown. Without a \a result, before the first field, there is only the state.
HudRows rowsOf(const midair::bridge::HologramResult* result,
               const ArrayNews& news,
               const OverlayRates& rates);

/// Returns the messages, the most important first, without the reason of \a alarm: what keeps the
/// array from playing, then what is left out, then what is done otherwise; the newest of each
/// first. Each begins with its cause and ends with the name of the node.
std::vector<std::string> messagesOf(const ArrayNews& news, const HudAlarm& alarm);

} // namespace osgMidair
