#pragma once

#include "device/ArrayDevice.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/tuning/TuningPlan.h"

#include <complex>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace midair::samples
{

/// Plays rows of a plan on a device, and knows whether it really does. Silences it at its end.
class RowPlayer
{
public:
    /// Opens the device. Throws device::DeviceError.
    RowPlayer(const std::string& uri,
              const haptics::TuningPlan& plan,
              const haptics::TransducerArray& array);
    ~RowPlayer(); ///< silences
    RowPlayer(const RowPlayer&) = delete;
    RowPlayer& operator=(const RowPlayer&) = delete;

    /// Plays a row and waits, at most \a patience_s, until the device says that it sounds. Returns
    /// false if \a goesOn did. Throws device::DeviceError where the device or its limits don't let
    /// it sound as the plan has it.
    bool play(int row, double patience_s, const std::function<bool()>& goesOn);

    /// Throws device::DeviceError if the row doesn't sound any more, or did not all the time.
    void requireThatItSounds();

    /// Says that the row is still wanted; a device with a hold falls silent without.
    void keepAlive() { _device->keepAlive(); }
    void silence() { _device->silence(); }

private:
    bool sounds() const;
    void requireThatItCan(int row, const device::DriveSignal& signal) const;

    const std::string _uri;
    const haptics::TuningPlan& _plan;
    const haptics::TransducerArray& _array;
    const std::unique_ptr<device::ArrayDevice> _device;
    std::vector<std::complex<float>> _wanted;
    int _row = -1;
    std::uint64_t _silences = 0;
};

} // namespace midair::samples
