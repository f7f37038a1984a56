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

/// Reaction of the other units when one is lost.
enum class WhenLost
{
    ALL_FALL_SILENT,
    ONE_IS_MISSED
};

/// The parameters of `autd3:`.
struct Autd3Options
{
    int units = 1;           ///< `units`, 1 .. kMostUnits
    std::string interface;   ///< `interface`; empty: the one that units answer on
    std::string group;       ///< `group`, "[ADDRESS]:PORT"; empty: the link-local group
    std::vector<int> order;  ///< `order`: board of each unit along the cable
    bool timed = true;       ///< `sync=time`: all switch at one time; false, `now`: at once
    double lead_s = 3e-3;    ///< `lead`, 0.5 .. 100 ms: time from sending to a timed switch
    double failsafe_s = 0.1; ///< `failsafe`, 20 ms .. 10 s: units fall silent without a frame for
                             ///< this time
    double heartbeat_s = 10e-3;                    ///< `heartbeat`, 1 ms .. failsafe / 3
    bool isHeartbeatNamed = false;                 ///< then the same at rest
    Silencer silencer;                             ///< `silencer`
    WhenLost whenLost = WhenLost::ALL_FALL_SILENT; ///< `lost`
    std::vector<std::vector<int>> silent;          ///< for each unit: masked transducers

    CpuConfig cpu() const; ///< settings for the CPU
    /// Heartbeat interval while fields or sequences are held.
    double restBeat_s() const;
};

/// Takes the parameters from \a uri. Throws DeviceError, which names the parameter, its value and
/// the expected value, also if they don't fit \a layout.
Autd3Options takeAutd3Options(DeviceUri& uri, const DeviceLayout& layout);

} // namespace midair::device::autd3
