#include "device/limits/GuardedDevice.h"

#include "device/DeviceUri.h"
#include "device/FieldCounters.h"
#include "device/JointCommit.h"
#include "device/drive/DriveEncoder.h"
#include "haptics/base/DutyLaw.h"
#include "haptics/base/text/Range.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace midair::device
{

namespace
{

// How strongly the drive may exceed the budget while the mean is below it: P <= B + kLead (B -
// mean). The mean of a quantity that obeys this approaches B from below and never passes it.
constexpr double kLead = 20;

constexpr double kMostPressure_Pa = 1e6;

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

double peakAmplitude(const DriveSignal& signal)
{
    return signal.duty.empty()
               ? 0
               : amplitudeLevels()[*std::max_element(signal.duty.begin(), signal.duty.end())];
}

void checkLimits(const SafetyLimits& limits)
{
    std::string error;
    const bool good = base::RangeCheck("device limits: ")
                          .within("maxAmplitude", limits.maxAmplitude, 0, 1)
                          .within("ramp", limits.ramp_s, 0, 10, " s")
                          .within("meanDrive", limits.meanDrive, 0, 1)
                          .above("meanDriveTime", limits.meanDriveTime_s, 0, " s")
                          .atLeast("hold", limits.hold_s, 0, " s")
                          .within("maxPressure", limits.maxPressure_Pa, 0, kMostPressure_Pa, " Pa")
                          .passed(&error);
    if (!good) throw DeviceError(error);
}

} // namespace

SafetyLimits takeLimits(DeviceUri& uri, const SafetyLimits& limits)
{
    SafetyLimits strict = limits;
    strict.maxAmplitude = std::min(limits.maxAmplitude, uri.takeNumber("max-amplitude", 1, 0, 1));
    strict.ramp_s = std::max(limits.ramp_s, uri.takeSeconds("ramp", 0));
    strict.meanDrive = std::min(limits.meanDrive, uri.takeNumber("mean-drive", 1, 0, 1));
    strict.meanDriveTime_s = uri.takeSeconds("mean-drive-time", limits.meanDriveTime_s);
    strict.maxPressure_Pa = stricterPressure(
        limits.maxPressure_Pa, uri.takeNumber("max-pressure", 0, 1, kMostPressure_Pa));
    const double hold_s = uri.takeSeconds("hold", 0);
    if (hold_s > 0) strict.hold_s = limits.hold_s > 0 ? std::min(limits.hold_s, hold_s) : hold_s;
    return strict;
}

double stricterPressure(double a_Pa, double b_Pa)
{
    return a_Pa > 0 && b_Pa > 0 ? std::min(a_Pa, b_Pa) : std::max(a_Pa, b_Pa);
}

void scaleDuties(const DriveSignal& signal, double gain, DriveSignal& scaled)
{
    scaled = signal;
    if (gain >= 1) return;
    std::array<std::uint8_t, 256> table{};
    for (int level = 1; level < 256; ++level)
    {
        const double exact = base::dutyLevel(std::max(0.0, gain) * base::dutyAmplitude(level));
        table[level] = static_cast<std::uint8_t>(exact + 1e-9);
    }
    for (std::uint8_t& duty : scaled.duty)
        duty = table[duty];
}

GuardedDevice::GuardedDevice(std::unique_ptr<ArrayDevice> device,
                             const SafetyLimits& limits,
                             int transducers,
                             std::unique_ptr<DeviceClaim> claim) :
    _claim(std::move(claim)),
    _device(std::move(device)),
    _limits(limits),
    _transducers(transducers)
{
    checkLimits(limits);
    _accounted_s = base::steadySeconds();
    if (limitsNeedTime()) _thread = std::thread([this] { run(); });
}

GuardedDevice::~GuardedDevice()
{
    {
        std::lock_guard<std::mutex> lock(_mutex);
        _closing = true;
    }
    _wake.notify_all();
    if (_thread.joinable()) _thread.join();
    _device->silence();
}

bool GuardedDevice::limitsNeedTime() const
{
    return _limits.ramp_s > 0 || _limits.meanDrive < 1 || _limits.hold_s > 0;
}

// Updates the mean over time since the last call: dE/dt = (P - E)/tau, P constant in between.
void GuardedDevice::account(double now_s)
{
    const double decay = std::exp(-(now_s - _accounted_s) / _limits.meanDriveTime_s);
    _meanDrive = _drive + (_meanDrive - _drive) * decay;
    _accounted_s = now_s;
}

double GuardedDevice::capGain(const DriveSignal& signal) const
{
    const double peak = peakAmplitude(signal);
    return peak > 0 ? std::min(1.0, maxAmplitude() / peak) : 1;
}

double GuardedDevice::allowedGain(double now_s)
{
    double gain = _ramp;
    if (_wantedPeak > 0) gain *= std::min(1.0, maxAmplitude() / _wantedPeak);
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

bool GuardedDevice::sendScaled(double now_s, const std::shared_ptr<JointCommit>& joint)
{
    _gain = allowedGain(now_s);
    scaleDuties(_wanted, _gain, _scaled);
    const bool taken = _device->sendTogether(_scaled, joint);
    _drive = taken && _limits.meanDrive < 1 ? meanSquare(_scaled) : 0;
    _sounds = taken;
    _inTurn = false;
    return taken;
}

bool GuardedDevice::sendTogether(const DriveSignal& signal,
                                 const std::shared_ptr<JointCommit>& joint)
{
    std::lock_guard<std::mutex> lock(_mutex);
    if (_muted || _closing || !signal.fits(_transducers))
    {
        ++_refused;
        if (joint != nullptr) joint->leave();
        return false;
    }
    const double now_s = base::steadySeconds();
    _wanted = signal;
    _wantedPeak = peakAmplitude(signal);
    _wantedDrive = _limits.meanDrive < 1 ? meanSquare(signal) : 0;
    if (_limits.ramp_s <= 0) _ramp = 1;
    _lastWanted_s = now_s;
    const bool started = !_sounds;
    const bool taken = sendScaled(now_s, joint);
    if (started && _thread.joinable()) _wake.notify_all();
    return taken;
}

// Each signal is scaled as it would be if sent alone.
bool GuardedDevice::sendSequence(const DriveSequence& sequence)
{
    std::lock_guard<std::mutex> lock(_mutex);
    const auto most = static_cast<std::size_t>(ability().sequenceFields);
    if (_muted || _closing || sequence.signals.size() > most || !sequence.fits(_transducers))
    {
        ++_refused;
        return false;
    }
    double loudest = 0;
    for (const DriveSignal& signal : sequence.signals)
        loudest = std::max(loudest, peakAmplitude(signal));
    const double cap = maxAmplitude();
    _gain = loudest > cap ? cap / loudest : 1;
    _inTurn = true;
    if (_gain == 1)
        _sounds = _device->sendSequence(sequence);
    else
    {
        DriveSequence scaled;
        scaled.rate_Hz = sequence.rate_Hz;
        scaled.signals.resize(sequence.signals.size());
        for (std::size_t k = 0; k < scaled.signals.size(); ++k)
            scaleDuties(sequence.signals[k], capGain(sequence.signals[k]), scaled.signals[k]);
        _sounds = _device->sendSequence(scaled);
    }
    return _sounds;
}

void GuardedDevice::silence()
{
    _device->silence(); // before the lock, so that a mute waits for no other thread
    std::lock_guard<std::mutex> lock(_mutex);
    _device->silence(); // again, for a field that run() or send() was just handing over
    noteSilence();
}

void GuardedDevice::setMuted(bool muted)
{
    if (muted) _device->setMuted(true); // as in silence()
    std::lock_guard<std::mutex> lock(_mutex);
    _muted = muted;
    _device->setMuted(muted);
    if (muted) noteSilence();
}

bool GuardedDevice::setAmplitudeCap(double amplitude)
{
    const std::lock_guard<std::mutex> lock(_mutex);
    const double before = maxAmplitude();
    _cap = amplitude >= 0 && amplitude <= 1 ? amplitude : 0; // also for NaN
    if (!_sounds || maxAmplitude() >= before) return true;
    if (!_inTurn &&
        (allowedGain(base::steadySeconds()) >= _gain || sendScaled(base::steadySeconds())))
        return true;
    _device->silence();
    noteSilence();
    return true;
}

void GuardedDevice::keepAlive()
{
    _lastWanted_s = base::steadySeconds();
}

void GuardedDevice::noteSilence()
{
    account(base::steadySeconds());
    ++_silences;
    _sounds = false;
    _drive = 0;
    _ramp = 0;
}

// Updates the gain as time passes: raises the ramp while a field is played, lowers it when closing;
// keeps the thermal budget and the hold.
void GuardedDevice::run()
{
    const double tick_s =
        std::min(0.02, _limits.ramp_s > 0 ? 0.002 : _limits.meanDriveTime_s / 100);
    std::unique_lock<std::mutex> lock(_mutex);
    double last_s = base::steadySeconds();
    while (!_closing || (_sounds && _ramp > 0 && _limits.ramp_s > 0))
    {
        if (_sounds)
            _wake.wait_for(lock,
                           std::chrono::duration<double>(tick_s),
                           [&] { return _closing && _limits.ramp_s <= 0; });
        else
        {
            _wake.wait(lock, [&] { return _sounds || _closing; });
            last_s = base::steadySeconds();
        }
        if (!_sounds) continue;
        const double now_s = base::steadySeconds();
        const double step = _limits.ramp_s > 0 ? (now_s - last_s) / _limits.ramp_s : 1;
        last_s = now_s;
        _ramp = std::clamp(_closing ? _ramp - step : _ramp + step, 0.0, 1.0);
        if (!_closing && _limits.hold_s > 0 && now_s - _lastWanted_s > _limits.hold_s)
        {
            _device->silence();
            noteSilence();
            continue;
        }
        // A change by less than half a duty level isn't worth a field.
        if (std::abs(allowedGain(now_s) - _gain) > 0.002 || (_gain < 1 && allowedGain(now_s) >= 1))
            sendScaled(now_s);
    }
}

DriveAbility GuardedDevice::ability() const
{
    DriveAbility ability = _device->ability();
    ability.maxPressure_Pa = stricterPressure(ability.maxPressure_Pa, _limits.maxPressure_Pa);
    if (limitsNeedTime()) ability.sequenceFields = 0;
    ability.fades = ability.fades || _limits.ramp_s > 0 || _limits.meanDrive < 1;
    return ability;
}

std::vector<std::complex<float>> GuardedDevice::wouldPlay(const DriveSignal& signal) const
{
    const double gain = capGain(signal);
    if (gain >= 1) return _device->wouldPlay(signal);
    DriveSignal scaled;
    scaleDuties(signal, gain, scaled);
    return _device->wouldPlay(scaled);
}

DeviceReport GuardedDevice::report() const
{
    DeviceReport report = _device->report();
    // Before the fields refused while muted are added: they are no shortfall.
    if (report.shortfall.empty()) report.shortfall = shortfallOf(report);
    std::lock_guard<std::mutex> lock(_mutex);
    report.sent += _refused;
    report.refused += _refused;
    report.silences += _silences;
    if (_muted && report.state == DeviceState::READY) report.state = DeviceState::MUTED;
    return report;
}

std::string GuardedDevice::status() const
{
    std::string text = _device->status();
    std::lock_guard<std::mutex> lock(_mutex);
    if (_muted) text += "; muted";
    if (_sounds && _gain < 1)
        text += fmt::format("; limited to {:g} % of the amplitude", std::round(_gain * 1000) / 10);
    return text;
}

} // namespace midair::device
