#pragma once

#include "device/ArrayDevice.h"

namespace midair::bridge
{

/// Tells from a device's reports whether it plays what it is sent, over its last fields, so that
/// single losses of a noisy line are no fault.
class PlayedShare
{
public:
    /// Takes a newer report in, and returns true if the device plays too few of its fields.
    bool isFaulty(const device::DeviceReport& report);
    /// Begins anew: what was lost before \a report counts no more.
    void forget(const device::DeviceReport& report);

private:
    std::uint64_t _settled = 0;
    std::uint64_t _played = 0;
    double _share = 1.0; ///< of the last fields, those that were played
    bool _faulty = false;
};

} // namespace midair::bridge
