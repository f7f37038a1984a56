#include "samples/tools/tune/RowPlayer.h"

#include "device/drive/DriveEncoder.h"
#include "engine-bridge/playing/unaided/UserDevice.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

constexpr double kTick_s = 2e-4;
// Of what is played against what is wanted; a duty level is up to 0.006 of full drive.
constexpr float kAmplitude = 0.02F;

void sleepFor(double seconds)
{
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

} // namespace

RowPlayer::RowPlayer(const std::string& uri,
                     const haptics::TuningPlan& plan,
                     const haptics::TransducerArray& array) :
    _uri(uri),
    _plan(plan),
    _array(array),
    _device(
        device::playsByItself(uri)
            ? throw device::DeviceError("device \"" + uri + "\": plays by itself and takes no plan")
            : bridge::openForUser(uri, {array.size(), array.board}, &array))
{
    if (_device->ability().maxPressure_Pa > 0)
        throw device::DeviceError("device \"" + uri +
                                  "\": max-pressure can't be held, the rows of a plan have no "
                                  "control points; max-amplitude and the plan's --duty limit them");
}

RowPlayer::~RowPlayer()
{
    _device->silence();
}

// What the device would play has to be what the plan has: readings of lowered rows would be taken
// for weak transducers. Foci may have their phases rounded.
void RowPlayer::requireThatItCan(int row, const device::DriveSignal& signal) const
{
    std::vector<std::complex<float>> planned;
    device::decode(signal, planned);
    for (std::size_t i = 0; i < planned.size(); ++i)
    {
        const bool isAsPlanned =
            _plan.method == haptics::TuningMethod::FOCUS
                ? std::abs(std::abs(_wanted[i]) - std::abs(planned[i])) <= kAmplitude
                : std::abs(_wanted[i] - planned[i]) <= kAmplitude;
        if (isAsPlanned) continue;
        throw device::DeviceError(fmt::format(
            "device \"{}\": row {} has transducer {} at {:.2f} of full drive and phase level {}; "
            "its "
            "levels or limits make {:.2f} of it, and {:.0f} of 256: plan with a lower --duty",
            _uri,
            row,
            i,
            std::abs(planned[i]),
            signal.phase[i],
            std::abs(_wanted[i]),
            std::fmod(std::arg(_wanted[i]) / 6.2831853F * 256.0F + 256.0F, 256.0F)));
    }
}

bool RowPlayer::sounds() const
{
    const device::DeviceReport report = _device->report();
    if (report.state != device::DeviceState::READY || report.pending > 0) return false;
    const std::vector<std::complex<float>> played = _device->played();
    if (played.size() != _wanted.size()) return false;
    for (std::size_t i = 0; i < played.size(); ++i)
        if (!(std::abs(played[i] - _wanted[i]) < kAmplitude)) return false;
    return true;
}

bool RowPlayer::play(int row, double patience_s, const std::function<bool()>& goesOn)
{
    const haptics::TuningDrive drive =
        haptics::driveOf(_plan, _plan.rows[static_cast<std::size_t>(row)], &_array);
    const device::DriveSignal signal{drive.phase, drive.duty};
    _wanted = _device->wouldPlay(signal);
    requireThatItCan(row, signal);
    _row = row;
    if (!_device->send(signal))
        throw device::DeviceError(
            fmt::format("device \"{}\": refuses row {}: {}", _uri, row, _device->status()));
    const double end_s = base::steadySeconds() + patience_s;
    while (!sounds())
    {
        if (!goesOn()) return false;
        const device::DeviceReport report = _device->report();
        if (report.state == device::DeviceState::LOST || base::steadySeconds() > end_s)
            throw device::DeviceError(fmt::format(
                "device \"{}\": row {} doesn't sound as planned within {:g} s: {}; a limit such as "
                "mean-drive may hold it down, then plan with a lower --duty",
                _uri,
                row,
                patience_s,
                _device->status()));
        keepAlive();
        sleepFor(kTick_s);
    }
    _silences = _device->report().silences;
    return true;
}

void RowPlayer::requireThatItSounds()
{
    if (sounds() && _device->report().silences == _silences) return;
    throw device::DeviceError(
        fmt::format("device \"{}\": row {} did not sound until it was read: {}",
                    _uri,
                    _row,
                    _device->status()));
}

} // namespace midair::samples
