#include "device/limits/LimitedDrive.h"

#include "device/drive/DriveEncoder.h"
#include "device/limits/QuietWatch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace midair::device
{

namespace
{

// How strongly the drive may exceed the budget while the mean is below it: P <= B + kLead (B -
// mean). The mean of a quantity that obeys this approaches B from below and never passes it.
constexpr double kLead = 20;

double meanSquare(const DriveSignal& signal)
{
    std::array<std::uint32_t, 256> histogram{};
    for (const std::uint8_t duty : signal.duty)
        ++histogram[duty];
    double sum = 0;
    for (int level = 1; level < 256; ++level)
        sum += histogram[level] * double(amplitudeLevels()[level]) * amplitudeLevels()[level];
    return sum / std::max<double>(1, signal.size());
}

} // namespace

double peakAmplitude(const DriveSignal& signal)
{
    return amplitudeLevels()[static_cast<std::size_t>(Loudness::of(signal).peak)];
}

double capGain(const DriveSignal& signal, double cap)
{
    const double peak = peakAmplitude(signal);
    return peak > 0 ? std::min(1.0, cap / peak) : 1;
}

LimitedDrive::LimitedDrive(const SafetyLimits& limits, double now_s) :
    _limits(limits),
    _accounted_s(now_s)
{
}

double LimitedDrive::step_s() const
{
    return std::min(0.02, _limits.ramp_s > 0 ? 0.002 : _limits.meanDriveTime_s / 100);
}

void LimitedDrive::want(const DriveSignal& signal)
{
    _wanted = signal;
    _wantedPeak = peakAmplitude(signal);
    _wantedDrive = _limits.meanDrive < 1 ? meanSquare(signal) : 0;
    if (_limits.ramp_s <= 0) _ramp = 1;
}

// Updates the mean over time since the last call: dE/dt = (P - E)/tau, P constant in between.
void LimitedDrive::account(double now_s)
{
    const double decay = std::exp(-(now_s - _accounted_s) / _limits.meanDriveTime_s);
    _meanDrive = _drive + (_meanDrive - _drive) * decay;
    _accounted_s = now_s;
}

double LimitedDrive::allowed(double cap, double now_s)
{
    double gain = _ramp;
    if (_wantedPeak > 0) gain *= std::min(1.0, cap / _wantedPeak);
    if (_limits.meanDrive < 1)
    {
        account(now_s);
        const double allowed =
            _limits.meanDrive + kLead * std::max(0.0, _limits.meanDrive - _meanDrive);
        const double drive = _wantedDrive * gain * gain;
        if (drive > allowed) gain *= std::sqrt(allowed / drive);
    }
    return gain;
}

const DriveSignal& LimitedDrive::lowered(double cap, double now_s)
{
    _gain = allowed(cap, now_s);
    scaleDuties(_wanted, _gain, _lowered);
    return _lowered;
}

void LimitedDrive::noteSent(bool taken)
{
    _drive = taken && _limits.meanDrive < 1 ? meanSquare(_lowered) : 0;
}

void LimitedDrive::noteSilence(double now_s)
{
    account(now_s);
    _drive = 0;
    _ramp = 0;
}

void LimitedDrive::passRamp(double passed_s, bool upwards)
{
    const double step = _limits.ramp_s > 0 ? passed_s / _limits.ramp_s : 1;
    _ramp = std::clamp(upwards ? _ramp + step : _ramp - step, 0.0, 1.0);
}

bool LimitedDrive::isDue(double cap, double now_s)
{
    const double gain = allowed(cap, now_s);
    return std::abs(gain - _gain) > 0.002 || (_gain < 1 && gain >= 1);
}

} // namespace midair::device
