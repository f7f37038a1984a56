#include "plugin/baking/BakingDevice.h"

#include "device/DeviceUri.h"
#include "device/limits/GuardedDevice.h"
#include "device/opening/MultiDevice.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

// Whole periods of this many steps are handed over in one piece; nothing is sent step by step, as
// nobody listens.
constexpr int kSequenceFields = 1 << 14;

} // namespace

BakingDevice::BakingDevice(int transducers) : _held(transducers) {}

bool BakingDevice::send(const midair::device::DriveSignal& signal)
{
    if (!signal.fits(_held.transducers()))
    {
        _counters.countRefused();
        return false;
    }
    _held.replace(signal);
    _counters.countPlayed(midair::base::steadySeconds());
    return true;
}

bool BakingDevice::sendSequence(const midair::device::DriveSequence& sequence)
{
    if (!sequence.fits(_held.transducers()))
    {
        _counters.countRefused();
        return false;
    }
    return send(sequence.signals.front());
}

midair::device::DriveAbility BakingDevice::ability() const
{
    midair::device::DriveAbility ability;
    ability.sequenceFields = kSequenceFields;
    return ability;
}

BakedLimits limitsOfDevice(const std::string& uri)
{
    using midair::device::SafetyLimits;
    BakedLimits all;
    for (const std::string& one : midair::device::splitDeviceList(uri))
    {
        midair::device::DeviceUri parsed(one);
        const SafetyLimits limits = midair::device::takeLimits(parsed, {});
        SafetyLimits& kept = all.limits;
        kept.maxAmplitude = std::min(kept.maxAmplitude, limits.maxAmplitude);
        kept.maxPressure_Pa =
            midair::device::stricterPressure(kept.maxPressure_Pa, limits.maxPressure_Pa);
        const auto leave = [&](const char* name, bool isSet)
        {
            if (!isSet) return;
            all.unkept.push_back(
                fmt::format("{} of the device \"{}\" goes by time and isn't in a recording: give "
                            "it to the device that plays, play:FILE?to={}:..?{}=..",
                            name,
                            one,
                            parsed.scheme(),
                            name));
        };
        leave("ramp", limits.ramp_s > 0.0);
        leave("mean-drive", limits.meanDrive < 1.0);
        leave("hold", limits.hold_s > 0.0);
    }
    return all;
}

} // namespace osgMidair
