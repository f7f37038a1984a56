#pragma once

#include "device/ArrayDevice.h"
#include "device/autd3/protocol/Commands.h"

#include <optional>
#include <string>
#include <vector>

namespace midair::device
{
class DeviceUri;
}

namespace midair::device::autd3
{

constexpr int kMostUnits = 64;

/// What happens to the others when a unit is lost.
enum class WhenLost
{
    ALL_FALL_SILENT,
    ONE_IS_MISSED
};

/// The parameters of `autd3:`.
struct Autd3Options
{
    int units = 1;           ///< `units`, 1 .. kMostUnits
    std::string interface;   ///< `interface`; empty: whichever units answer on
    std::string group;       ///< `group`, "[ADDRESS]:PORT"; empty: the link-local group
    std::vector<int> order;  ///< `order`: the board that each unit, along the cable, plays
    bool timed = true;       ///< `sync=time`: all switch at one time; false, `now`: at once
    double lead_s = 3e-3;    ///< `lead`, 0.5 .. 100 ms: how far ahead a timed switch is
    double failsafe_s = 0.1; ///< `failsafe`, 20 ms .. 10 s: without a sign of us units fall silent
    double heartbeat_s = 10e-3;                    ///< `heartbeat`, 1 ms .. failsafe / 3
    bool isHeartbeatNamed = false;                 ///< then it is the same at rest
    Silencer silencer;                             ///< `silencer`
    WhenLost whenLost = WhenLost::ALL_FALL_SILENT; ///< `lost`
    std::vector<std::vector<int>> silent;          ///< of each unit: transducers to be masked

    CpuConfig cpu() const; ///< the settings that follow
    /// From one heartbeat to the next while fields, or sequences, stand.
    double restBeat_s() const;
};

/// Takes the parameters from \a uri. Throws DeviceError, which names the parameter, its value and
/// what would be right, also where they don't fit \a layout.
Autd3Options takeAutd3Options(DeviceUri& uri, const DeviceLayout& layout);

} // namespace midair::device::autd3
