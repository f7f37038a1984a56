#pragma once

#include "device/autd3/emulator/unit/EmulatedClock.h"

#include <cstdint>
#include <vector>

namespace midair::device
{
class DeviceUri;
}

namespace midair::device::emulation
{

/// What goes wrong on a cable with units. Probabilities (0 .. 1) are for each datagram, either way;
/// times are since the beginning.
struct ChainFaults
{
    double drop = 0;
    double duplicate = 0;
    double reorder = 0;     ///< it comes reorder_ns late, so that others overtake it
    double garbage = 0;     ///< for each answer another one, damaged or foreign, comes before it
    double error = 0;       ///< for each frame: its unit's next command fails
    Time_ns latency_ns = 0; ///< >= 0; each way
    Time_ns jitter_ns = 0;  ///< >= 0; up to so much is added
    Time_ns reorder_ns = 2 * kMillisecond_ns;
    unsigned seed = 1;
    std::uint8_t errorResult = 0x07; ///< what failing commands end with
    int lostAssignments = 0;         ///< so many first answers to AssignId are lost

    /// Something that happens to a unit at a time; what is said of it is in Event's names.
    enum class Kind
    {
        REBOOT,
        SYNC_LOST, ///< its clock runs by itself from then on
        SYNC_BACK,
        FAILSAFE, ///< tripped, whatever is sent
        HOT,
        UNPLUG, ///< the host's cable; the unit doesn't matter
        REPLUG,
        HANG ///< the host's datagrams no longer come through; answers do
    };
    struct Event
    {
        Time_ns at_ns = 0;
        Kind kind = Kind::REBOOT;
        int unit = 0;
    };
    std::vector<Event> events;
};

/// What units are emulated, and on what cable.
struct ChainOptions
{
    int units = 1; ///< 1 .. 64
    int protocolVersion = 2;
    int firmware[3] = {0, 10, 0};  ///< of the CPU
    int gateware[3] = {0, 10, 0};  ///< of the FPGA
    Time_ns wirePerByte_ns = 0;    ///< 80 of a 100 Mbit/s cable; 0: no time
    Time_ns perFrame_ns = 0;       ///< the units' CPUs, for each command ..
    Time_ns perWord_ns = 0;        ///< .. and each 16-bit word
    Time_ns settle_ns = 0;         ///< until clocks follow, from SetTime or from getting an id
    Time_ns boot_ns = 0;           ///< of a unit
    std::int64_t drift_ppm = 0;    ///< of the units' clocks against the host's, up to 1000
    Time_ns clockError_ns = 0;     ///< units that follow are within so much of the grandmaster
    Time_ns tolerance_ns = 50'000; ///< a change of field may take so long
    ChainFaults faults;

    /// As units on a real cable are known or guessed to be.
    static ChainOptions realistic(int units);
};

/// Takes units, faults and what else is known from \a uri; throws DeviceError. Beginning with
/// \a defaults.
ChainOptions takeChainOptions(DeviceUri& uri, const ChainOptions& defaults);

} // namespace midair::device::emulation
