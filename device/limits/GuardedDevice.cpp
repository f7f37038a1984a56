#include "device/limits/GuardedDevice.h"

#include "device/DeviceLog.h"
#include "device/FieldCounters.h"
#include "device/JointCommit.h"
#include "device/drive/DriveEncoder.h"
#include "device/limits/QuietWatch.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace midair::device
{

namespace
{

// How far the drive may exceed the budget while the mean is below it: P <= B + kLead (B - mean).
// The mean of such a drive approaches B from below and never exceeds it.
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

constexpr double kLongSleep_s = 3600;
constexpr double kLate_s = 0.5e-3; // so that due actions are overdue when the thread checks
// Fields that a line may still carry before one is confirmed: the one on it, and its own.
constexpr double kLineFields = 2.5;

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

double LimitedDrive::mostGain(double cap) const
{
    return _wantedPeak > 0 ? std::min(1.0, cap / _wantedPeak) : 1.0;
}

double LimitedDrive::allowed(double cap, double now_s)
{
    double gain = _ramp * mostGain(cap);
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

// A refused field changes nothing: the previous one may still play, and counts.
void LimitedDrive::noteSent(bool taken)
{
    if (taken) _drive = _limits.meanDrive < 1 ? meanSquare(_lowered) : 0;
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
    const double gain = allowed(cap, now_s), most = mostGain(cap);
    return std::abs(gain - _gain) > 0.002 || (_gain < most && gain >= most);
}

GuardedDevice::GuardedDevice(std::unique_ptr<ArrayDevice> device,
                             const SafetyLimits& limits,
                             int transducers,
                             std::unique_ptr<DeviceClaim> claim,
                             const base::Clock& clock) :
    _claim(std::move(claim)),
    _device(std::move(device)),
    _limits(limits),
    _transducers(transducers),
    _clock(clock),
    _lead(std::make_shared<Lead>(clock)),
    _drive(limits, clock.now_s())
{
    checkLimits(limits);
    const base::Lock lock(_mutex);
    if (_drive.needsTime() || limits.hold_s > 0) _watchman.thread = std::thread([this] { run(); });
}

GuardedDevice::~GuardedDevice()
{
    std::thread thread;
    {
        const base::Lock lock(_mutex);
        _watchman.closing = true;
        thread.swap(_watchman.thread);
    }
    _wake.notifyAll();
    if (thread.joinable()) thread.join();
    _device->silence();
}

double GuardedDevice::cap() const
{
    return std::min(_limits.maxAmplitude, lead()->amplitudeCap());
}

bool GuardedDevice::sendLowered(const std::shared_ptr<JointCommit>& joint)
{
    _sounding.cap = cap();
    const DriveSignal& lowered = _drive.lowered(_sounding.cap, _clock.now_s());
    const double asked_s = _clock.now_s();
    const bool taken = _device->sendTogether(lowered, joint);
    ask(Loudness::of(lowered), asked_s, taken);
    _drive.noteSent(taken);
    _sounding.isAny = taken;
    _sounding.inTurn = false;
    return taken;
}

bool GuardedDevice::refuse()
{
    ++_counts.refused;
    watchHold();
    return false;
}

// New output may be due before the thread's next check.
void GuardedDevice::wake()
{
    if (_watchman.thread.joinable() && nextDue_s() < _watchman.wakeAt_s) _wake.notifyAll();
}

bool GuardedDevice::sendTogether(const DriveSignal& signal,
                                 const std::shared_ptr<JointCommit>& joint)
{
    const base::Lock lock(_mutex);
    if (lead()->isMuted() || _watchman.closing || !signal.fits(_transducers) || isHoldOver())
    {
        if (joint != nullptr) joint->leave();
        return refuse();
    }
    _sounding.isAbandoned = false;
    _drive.want(signal);
    const bool started = !_sounding.isAny;
    const bool taken = sendLowered(joint);
    if (started) wake();
    return taken;
}

// Each signal is scaled as if sent alone.
bool GuardedDevice::sendSequence(const DriveSequence& sequence)
{
    const base::Lock lock(_mutex);
    const auto most = static_cast<std::size_t>(ability().sequenceFields);
    if (lead()->isMuted() || _watchman.closing || sequence.signals.size() > most ||
        !sequence.fits(_transducers) || isHoldOver())
        return refuse();
    _sounding.isAbandoned = false;
    double loudest = 0;
    for (const DriveSignal& signal : sequence.signals)
        loudest = std::max(loudest, peakAmplitude(signal));
    const double cap = this->cap();
    _sounding.cap = cap;
    _sounding.inTurn = true;
    const double gain = loudest > cap ? cap / loudest : 1;
    _drive.noteSequence(gain);
    DriveSequence scaled;
    if (gain < 1)
    {
        scaled.rate_Hz = sequence.rate_Hz;
        scaled.signals.resize(sequence.signals.size());
        for (std::size_t k = 0; k < scaled.signals.size(); ++k)
            scaleDuties(sequence.signals[k], capGain(sequence.signals[k], cap), scaled.signals[k]);
    }
    const DriveSequence& played = gain < 1 ? scaled : sequence;
    Loudness level;
    for (const DriveSignal& signal : played.signals)
        level.raiseTo(Loudness::of(signal));
    const double asked_s = _clock.now_s();
    const bool started = !_sounding.isAny;
    const bool taken = _device->sendSequence(played);
    _sounding.isAny = taken;
    ask(level, asked_s, taken);
    if (started) wake();
    return taken;
}

void GuardedDevice::silence()
{
    _device->silence(); // before the lock, so that a mute waits for no other thread
    const base::Lock lock(_mutex);
    silenceLocked(); // again, for a field that run() or send() was handing over
}

// From the first line on, new fields are refused; a field that another thread is handing over is
// silenced when it releases the lock.
void GuardedDevice::setMuted(bool muted)
{
    if (muted) lead()->setMuted(true);
    if (muted) _device->setMuted(true); // as in silence()
    const base::Lock lock(_mutex);
    lead()->setMuted(muted);
    const double asked_s = _clock.now_s();
    _device->setMuted(muted);
    if (!muted) return;
    noteSilence();
    ask({}, asked_s);
}

bool GuardedDevice::setAmplitudeCap(double amplitude)
{
    const base::Lock lock(_mutex);
    lead()->setAmplitudeCap(amplitude);
    if (!maySound() || cap() >= _sounding.cap) return true;
    if (_sounding.isAny && !_sounding.inTurn &&
        (_drive.allowed(cap(), _clock.now_s()) >= _drive.gain() || sendLowered()))
        return true;
    _sounding.cap = cap();
    silenceLocked();
    return true;
}

// A mute stays until it is lifted, so the new lead gets it, too.
void GuardedDevice::follow(const std::shared_ptr<Lead>& lead)
{
    const std::shared_ptr<Lead> before = std::atomic_exchange(&_lead, lead);
    if (before->isMuted() || lead->isMuted()) setMuted(true);
    setAmplitudeCap(lead->amplitudeCap());
    const base::Lock lock(_mutex);
    wake(); // its last sign of life may be older
}

bool GuardedDevice::isHoldOver() const
{
    return _limits.hold_s > 0 && _clock.now_s() - lead()->sign_s() > _limits.hold_s;
}

void GuardedDevice::silenceLocked()
{
    const double asked_s = _clock.now_s();
    _device->silence();
    noteSilence();
    ask({}, asked_s);
}

void GuardedDevice::noteSilence()
{
    _drive.noteSilence(_clock.now_s());
    ++_counts.silences;
    _sounding.isAny = false;
}

// Notes output handed to the device at asked_s; level: none for a silence. The thread watches
// requests that aren't confirmed within the call; many devices have none.
void GuardedDevice::ask(const std::optional<Loudness>& level, double asked_s, bool taken)
{
    settle();
    if (level)
        _quieting.watch.ask(*level, asked_s, taken);
    else
        _quieting.watch.askSilence(asked_s);
    settle();
    if (_quieting.watch.since_s() <= 0 || _watchman.closing) return;
    if (!_watchman.thread.joinable())
        _watchman.thread = std::thread([this] { run(); });
    else
        wake();
}

void GuardedDevice::settle() const
{
    _quieting.watch.confirm(_device->confirmed_s());
    if (_quieting.watch.doubted_s() <= 0) _quieting.unsilenced.clear();
    if (_quieting.watch.sounds()) _quieting.quieted.clear();
}

bool GuardedDevice::maySound() const
{
    return _sounding.isAny || _quieting.watch.maySound();
}

void GuardedDevice::watchHold()
{
    if (_sounding.isAbandoned || _watchman.closing || !maySound() || !isHoldOver()) return;
    _sounding.isAbandoned = true;
    silenceLocked();
    deviceLog().warn("{}: silenced, because there was no sign of life for {:g} s (hold)",
                     _device->status(),
                     _limits.hold_s);
}

// A lost device is reported, and its driver silences it before it plays again.
void GuardedDevice::watchQuieting()
{
    settle();
    Quieting& quieting = _quieting;
    QuietWatch& watch = quieting.watch;
    const double now_s = _clock.now_s();
    if (!watch.isOverdue(now_s, QuietWatch::kConfirm_s)) return;
    const double rate = _device->ability().fieldsPerSecond;
    quieting.patience_s = std::max(QuietWatch::kConfirm_s, rate > 0 ? kLineFields / rate : 0);
    if (!watch.isOverdue(now_s, quieting.patience_s)) return;
    const DeviceReport report = _device->report();
    if (report.state == DeviceState::LOST) return watch.forget();
    const std::string why = report.message.empty() ? "" : ": " + report.message;
    std::string& text =
        watch.isSilence() || watch.doubted_s() > 0 ? quieting.unsilenced : quieting.quieted;
    if (text.empty())
    {
        text = fmt::format(&text == &quieting.quieted
                               ? "a quieter field wasn't confirmed within {:.0f} ms, so it is "
                                 "silenced{}"
                               : "a silence wasn't confirmed within {:.0f} ms, so it may still "
                                 "play; it is silenced again{}",
                           1000 * quieting.patience_s,
                           why);
        if (report.unsilenced.empty()) // otherwise its driver has counted and reported it
        {
            ++quieting.faults;
            deviceLog().error("{}: {}", _device->status(), text);
        }
    }
    if (_sounding.isAny || watch.doubted_s() <= 0) noteSilence();
    _device->silence();
    watch.doubt(now_s);
}

double GuardedDevice::nextDue_s() const
{
    double due_s = std::numeric_limits<double>::infinity();
    if (_sounding.isAny && _drive.needsTime()) due_s = _clock.now_s() + _drive.step_s();
    if (_limits.hold_s > 0 && !_sounding.isAbandoned && maySound())
        due_s = std::min(due_s, lead()->sign_s() + _limits.hold_s);
    const QuietWatch& watch = _quieting.watch;
    if (watch.since_s() > 0) due_s = std::min(due_s, watch.tried_s() + _quieting.patience_s);
    return due_s;
}

// Updates the gain over time: raises the ramp while a field plays, lowers it when closing; keeps
// the thermal budget; runs the watchdogs.
void GuardedDevice::run()
{
    base::Lock lock(_mutex);
    double last_s = _clock.now_s();
    while (!_watchman.closing || (_sounding.isAny && _drive.isRampedUp()))
    {
        const bool sounded = _sounding.isAny;
        const double begin_s = _clock.now_s();
        _watchman.wakeAt_s =
            begin_s + std::clamp(nextDue_s() - begin_s, 0.0, kLongSleep_s) + kLate_s;
        _clock.wait(_wake, lock, _watchman.wakeAt_s);
        _watchman.wakeAt_s = 0;
        const double now_s = _clock.now_s();
        if (!sounded) last_s = now_s;
        watchHold();
        if (!_watchman.closing) watchQuieting();
        if (!_sounding.isAny || _sounding.inTurn) continue; // a sequence has a constant gain
        _drive.passRamp(now_s - last_s, !_watchman.closing);
        last_s = now_s;
        if (_drive.isDue(cap(), now_s)) sendLowered();
    }
}

DriveAbility GuardedDevice::ability() const
{
    const bool needsTime = _limits.ramp_s > 0 || _limits.meanDrive < 1;
    DriveAbility ability = _device->ability();
    ability.maxPressure_Pa = stricterCap(ability.maxPressure_Pa, _limits.maxPressure_Pa);
    ability.maxAmplitude = std::min(ability.maxAmplitude, _limits.maxAmplitude);
    if (needsTime) ability.sequenceFields = 0;
    ability.fades = ability.fades || needsTime;
    return ability;
}

std::vector<std::complex<float>> GuardedDevice::wouldPlay(const DriveSignal& signal) const
{
    const double gain = capGain(signal, cap());
    if (gain >= 1) return _device->wouldPlay(signal);
    DriveSignal scaled;
    scaleDuties(signal, gain, scaled);
    return _device->wouldPlay(scaled);
}

DeviceReport GuardedDevice::report() const
{
    DeviceReport report = _device->report();
    // Before adding fields refused while muted, which are no shortfall.
    if (report.shortfall.empty()) report.shortfall = shortfallOf(report);
    const base::Lock lock(_mutex);
    settle();
    report.sent += _counts.refused;
    report.refused += _counts.refused;
    report.silences += _counts.silences;
    report.faults += _quieting.faults;
    report.quieted = _quieting.quieted;
    if (lead()->isMuted() && report.state == DeviceState::READY) report.state = DeviceState::MUTED;
    if (_quieting.unsilenced.empty() || report.state >= DeviceState::HANGING) return report;
    if (report.unsilenced.empty()) report.unsilenced = _quieting.unsilenced;
    if (_clock.now_s() - _quieting.watch.doubted_s() <= QuietWatch::kHangs_s) return report;
    report.state = DeviceState::HANGING;
    report.message = _quieting.unsilenced;
    return report;
}

std::string GuardedDevice::status() const
{
    std::string text = _device->status();
    const base::Lock lock(_mutex);
    if (lead()->isMuted()) text += "; muted";
    if (_sounding.isAbandoned)
        text += fmt::format("; silent: no sign of life for {:g} s", _limits.hold_s);
    if (!_quieting.quieted.empty()) text += "; " + _quieting.quieted;
    if (!_quieting.unsilenced.empty()) text += "; " + _quieting.unsilenced;
    if (_sounding.isAny && _drive.gain() < 1)
        text += fmt::format("; limited to {:g} % of the amplitude",
                            std::round(_drive.gain() * 1000) / 10);
    return text;
}

} // namespace midair::device
