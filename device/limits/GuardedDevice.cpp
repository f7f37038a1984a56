#include "device/limits/GuardedDevice.h"

#include "device/DeviceLog.h"
#include "device/FieldCounters.h"
#include "device/JointCommit.h"
#include "device/drive/DriveEncoder.h"
#include "haptics/base/DutyLaw.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace midair::device
{

namespace
{

// How strongly the drive may exceed the budget while the mean is below it: P <= B + kLead (B -
// mean). The mean of a quantity that obeys this approaches B from below and never passes it.
constexpr double kLead = 20;

constexpr double kLongSleep_s = 3600;
constexpr double kLate_s = 0.5e-3; // so that what is due is over when the thread looks
// Fields that a line may still have to carry before one is confirmed: the one on it, and its own.
constexpr double kLineFields = 2.5;

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
    return amplitudeLevels()[static_cast<std::size_t>(Loudness::of(signal).peak)];
}

} // namespace

GuardedDevice::GuardedDevice(std::unique_ptr<ArrayDevice> device,
                             const SafetyLimits& limits,
                             int transducers,
                             std::unique_ptr<DeviceClaim> claim) :
    _claim(std::move(claim)),
    _device(std::move(device)),
    _limits(limits),
    _transducers(transducers),
    _lastSign_s(base::steadySeconds())
{
    checkLimits(limits);
    _accounted_s = base::steadySeconds();
    if (gainNeedsTime() || limits.hold_s > 0) _thread = std::thread([this] { run(); });
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
    const double asked_s = base::steadySeconds();
    const bool taken = _device->sendTogether(_scaled, joint);
    ask(Loudness::of(_scaled), asked_s, taken);
    _drive = taken && _limits.meanDrive < 1 ? meanSquare(_scaled) : 0;
    _sounds = taken;
    _inTurn = false;
    return taken;
}

bool GuardedDevice::sendTogether(const DriveSignal& signal,
                                 const std::shared_ptr<JointCommit>& joint)
{
    std::lock_guard<std::mutex> lock(_mutex);
    if (_muted || _closing || !signal.fits(_transducers) || isHoldOver())
    {
        ++_refused;
        if (joint != nullptr) joint->leave();
        watchHold();
        return false;
    }
    _isAbandoned = false;
    const double now_s = base::steadySeconds();
    _wanted = signal;
    _wantedPeak = peakAmplitude(signal);
    _wantedDrive = _limits.meanDrive < 1 ? meanSquare(signal) : 0;
    if (_limits.ramp_s <= 0) _ramp = 1;
    const bool started = !_sounds;
    const bool taken = sendScaled(now_s, joint);
    if (started && _thread.joinable() && nextDue_s() < _wakeAt_s) _wake.notify_all();
    return taken;
}

// Each signal is scaled as it would be if sent alone.
bool GuardedDevice::sendSequence(const DriveSequence& sequence)
{
    std::lock_guard<std::mutex> lock(_mutex);
    const auto most = static_cast<std::size_t>(ability().sequenceFields);
    if (_muted || _closing || sequence.signals.size() > most || !sequence.fits(_transducers) ||
        isHoldOver())
    {
        ++_refused;
        watchHold();
        return false;
    }
    _isAbandoned = false;
    double loudest = 0;
    for (const DriveSignal& signal : sequence.signals)
        loudest = std::max(loudest, peakAmplitude(signal));
    const double cap = maxAmplitude();
    _gain = loudest > cap ? cap / loudest : 1;
    _inTurn = true;
    DriveSequence scaled;
    if (_gain < 1)
    {
        scaled.rate_Hz = sequence.rate_Hz;
        scaled.signals.resize(sequence.signals.size());
        for (std::size_t k = 0; k < scaled.signals.size(); ++k)
            scaleDuties(sequence.signals[k], capGain(sequence.signals[k]), scaled.signals[k]);
    }
    const DriveSequence& played = _gain < 1 ? scaled : sequence;
    Loudness level;
    for (const DriveSignal& signal : played.signals)
        level.raiseTo(Loudness::of(signal));
    const double asked_s = base::steadySeconds();
    const bool started = !_sounds;
    _sounds = _device->sendSequence(played);
    ask(level, asked_s, _sounds);
    if (started && _thread.joinable() && nextDue_s() < _wakeAt_s) _wake.notify_all();
    return _sounds;
}

void GuardedDevice::silence()
{
    _device->silence(); // before the lock, so that a mute waits for no other thread
    std::lock_guard<std::mutex> lock(_mutex);
    silenceLocked(); // again, for a field that run() or send() was just handing over
}

void GuardedDevice::setMuted(bool muted)
{
    if (muted) _device->setMuted(true); // as in silence()
    std::lock_guard<std::mutex> lock(_mutex);
    _muted = muted;
    const double asked_s = base::steadySeconds();
    _device->setMuted(muted);
    if (!muted) return;
    noteSilence();
    ask({}, asked_s);
}

bool GuardedDevice::setAmplitudeCap(double amplitude)
{
    const std::lock_guard<std::mutex> lock(_mutex);
    const double before = maxAmplitude();
    _cap = amplitude >= 0 && amplitude <= 1 ? amplitude : 0; // also for NaN
    if (!(_sounds || _quiet.maySound()) || maxAmplitude() >= before) return true;
    if (_sounds && !_inTurn &&
        (allowedGain(base::steadySeconds()) >= _gain || sendScaled(base::steadySeconds())))
        return true;
    silenceLocked();
    return true;
}

bool GuardedDevice::isHoldOver() const
{
    return _limits.hold_s > 0 && base::steadySeconds() - _lastSign_s > _limits.hold_s;
}

void GuardedDevice::silenceLocked()
{
    const double asked_s = base::steadySeconds();
    _device->silence();
    noteSilence();
    ask({}, asked_s);
}

void GuardedDevice::noteSilence()
{
    account(base::steadySeconds());
    ++_silences;
    _sounds = false;
    _drive = 0;
    _ramp = 0;
}

// Takes note of what was handed to the device at asked_s; level: none for a silence. The thread
// watches what isn't confirmed within the call, which with many devices is nothing.
void GuardedDevice::ask(const std::optional<Loudness>& level, double asked_s, bool taken)
{
    settle();
    if (level)
        _quiet.ask(*level, asked_s, taken);
    else
        _quiet.askSilence(asked_s);
    settle();
    if (_quiet.since_s() <= 0 || _closing) return;
    if (!_thread.joinable())
        _thread = std::thread([this] { run(); });
    else if (nextDue_s() < _wakeAt_s)
        _wake.notify_all();
}

void GuardedDevice::settle() const
{
    _quiet.confirm(_device->confirmed_s());
    if (_quiet.doubted_s() <= 0) _unsilenced.clear();
    if (_quiet.sounds()) _quieted.clear();
}

void GuardedDevice::watchHold()
{
    if (_isAbandoned || _closing || !(_sounds || _quiet.maySound()) || !isHoldOver()) return;
    _isAbandoned = true;
    silenceLocked();
    deviceLog().warn("{}: silenced, for there was no sign of life for {:g} s (hold)",
                     _device->status(),
                     _limits.hold_s);
}

// A lost device is told, and silenced by its driver before it plays again.
void GuardedDevice::watchQuieting()
{
    settle();
    const double now_s = base::steadySeconds();
    if (!_quiet.isOverdue(now_s, QuietWatch::kConfirm_s)) return;
    const double rate = _device->ability().fieldsPerSecond;
    _patience_s = std::max(QuietWatch::kConfirm_s, rate > 0 ? kLineFields / rate : 0);
    if (!_quiet.isOverdue(now_s, _patience_s)) return;
    const DeviceReport report = _device->report();
    if (report.state == DeviceState::LOST) return _quiet.forget();
    const std::string why = report.message.empty() ? "" : ": " + report.message;
    std::string& text = _quiet.isSilence() || _quiet.doubted_s() > 0 ? _unsilenced : _quieted;
    if (text.empty())
    {
        text = fmt::format(&text == &_quieted
                               ? "a quieter field wasn't confirmed within {:.0f} ms, so it is "
                                 "silenced{}"
                               : "it was asked for silence and hasn't confirmed that within {:.0f} "
                                 "ms, so it may play on; it is asked again{}",
                           1000 * _patience_s,
                           why);
        if (report.unsilenced.empty()) // else its driver has counted and told it
        {
            ++_faults;
            deviceLog().error("{}: {}", _device->status(), text);
        }
    }
    if (_sounds || _quiet.doubted_s() <= 0) noteSilence();
    _device->silence();
    _quiet.doubt(now_s);
}

double GuardedDevice::nextDue_s() const
{
    double due_s = std::numeric_limits<double>::infinity();
    if (_sounds && gainNeedsTime())
        due_s = base::steadySeconds() +
                std::min(0.02, _limits.ramp_s > 0 ? 0.002 : _limits.meanDriveTime_s / 100);
    if (_limits.hold_s > 0 && !_isAbandoned && (_sounds || _quiet.maySound()))
        due_s = std::min(due_s, _lastSign_s + _limits.hold_s);
    if (_quiet.since_s() > 0) due_s = std::min(due_s, _quiet.tried_s() + _patience_s);
    return due_s;
}

// Updates the gain as time passes: raises the ramp while a field is played, lowers it when closing;
// keeps the thermal budget; watches.
void GuardedDevice::run()
{
    std::unique_lock<std::mutex> lock(_mutex);
    double last_s = base::steadySeconds();
    while (!_closing || (_sounds && _ramp > 0 && _limits.ramp_s > 0))
    {
        const bool sounded = _sounds;
        const double rest_s =
            std::clamp(nextDue_s() - base::steadySeconds(), 0.0, kLongSleep_s) + kLate_s;
        _wakeAt_s = base::steadySeconds() + rest_s;
        _wake.wait_for(lock, std::chrono::duration<double>(rest_s));
        _wakeAt_s = 0;
        const double now_s = base::steadySeconds();
        if (!sounded) last_s = now_s;
        watchHold();
        if (!_closing) watchQuieting();
        if (!_sounds || _inTurn) continue; // a sequence has no gain that changes
        const double step = _limits.ramp_s > 0 ? (now_s - last_s) / _limits.ramp_s : 1;
        last_s = now_s;
        _ramp = std::clamp(_closing ? _ramp - step : _ramp + step, 0.0, 1.0);
        // A change by less than half a duty level isn't worth a field.
        if (std::abs(allowedGain(now_s) - _gain) > 0.002 || (_gain < 1 && allowedGain(now_s) >= 1))
            sendScaled(now_s);
    }
}

DriveAbility GuardedDevice::ability() const
{
    DriveAbility ability = _device->ability();
    ability.maxPressure_Pa = stricterPressure(ability.maxPressure_Pa, _limits.maxPressure_Pa);
    if (gainNeedsTime()) ability.sequenceFields = 0;
    ability.fades = ability.fades || gainNeedsTime();
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
    settle();
    report.sent += _refused;
    report.refused += _refused;
    report.silences += _silences;
    report.faults += _faults;
    report.quieted = _quieted;
    if (_muted && report.state == DeviceState::READY) report.state = DeviceState::MUTED;
    if (_unsilenced.empty() || report.state >= DeviceState::HANGING) return report;
    if (report.unsilenced.empty()) report.unsilenced = _unsilenced;
    if (base::steadySeconds() - _quiet.doubted_s() <= QuietWatch::kHangs_s) return report;
    report.state = DeviceState::HANGING;
    report.message = _unsilenced;
    return report;
}

std::string GuardedDevice::status() const
{
    std::string text = _device->status();
    std::lock_guard<std::mutex> lock(_mutex);
    if (_muted) text += "; muted";
    if (_isAbandoned) text += fmt::format("; silent: no sign of life for {:g} s", _limits.hold_s);
    if (!_quieted.empty()) text += "; " + _quieted;
    if (!_unsilenced.empty()) text += "; " + _unsilenced;
    if (_sounds && _gain < 1)
        text += fmt::format("; limited to {:g} % of the amplitude", std::round(_gain * 1000) / 10);
    return text;
}

} // namespace midair::device
