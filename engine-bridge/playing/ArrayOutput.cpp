#include "engine-bridge/playing/ArrayOutput.h"

#include "device/drive/DriveEncoder.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

constexpr double kMemory = 0.95; // weight of the older fields: some 20 count
// Two thresholds, so that a line that loses many fields doesn't alternate between fault and
// playing.
constexpr double kFaulty = 0.4;
constexpr double kWell = 0.6;

Eigen::VectorXcf vectorOf(const std::vector<std::complex<float>>& q)
{
    return Eigen::Map<const Eigen::VectorXcf>(q.data(), static_cast<Eigen::Index>(q.size()));
}

bool isAnything(const device::DriveSignal& drive)
{
    return std::any_of(
        drive.duty.begin(), drive.duty.end(), [](std::uint8_t duty) { return duty > 0; });
}

constexpr double kRest_s = 0.2; // a field held for longer belongs to a scene at rest

ArrayFields fieldsOf(const device::DeviceReport& report)
{
    ArrayFields fields;
    fields.sent = report.sent;
    fields.played = report.played;
    fields.dropped = report.dropped;
    fields.lost = report.lost;
    fields.refused = report.refused;
    fields.waiting = report.pending;
    fields.faults = report.faults;
    fields.reconnects = report.reconnects;
    return fields;
}

} // namespace

// Fields that a newer one replaced or a mute refused were never due for playing.
bool PlayedShare::isFaulty(const device::DeviceReport& report)
{
    const std::uint64_t played = report.played;
    const std::uint64_t settled = played + report.lost;
    if (settled < _settled || played < _played) _settled = _played = 0; // report of another device
    const auto news = static_cast<double>(settled - _settled);
    if (news > 0.0)
    {
        const double old = std::pow(kMemory, news);
        _share = old * _share + (1.0 - old) * static_cast<double>(played - _played) / news;
    }
    _settled = settled;
    _played = played;
    _faulty = _share < (_faulty ? kWell : kFaulty);
    return _faulty;
}

void PlayedShare::forget(const device::DeviceReport& report)
{
    _played = report.played;
    _settled = report.played + report.lost;
    _share = 1.0;
    _faulty = false;
}

std::vector<device::DriveSignal>
drivesOf(const std::vector<Eigen::VectorXcf>& fields, int transducers, const std::vector<int>& dead)
{
    std::vector<device::DriveSignal> drives(fields.size());
    for (std::size_t k = 0; k < drives.size(); ++k)
    {
        const Eigen::VectorXcf& q = fields[k];
        if (q.size() != transducers)
            throw std::runtime_error(
                fmt::format("solver gave {} activations for {} transducers; nothing is played",
                            q.size(),
                            transducers));
        if (!device::encode(q.data(), transducers, drives[k]))
            throw std::runtime_error(
                "solver gave activations that are not finite; nothing is played");
        for (const int i : dead)
            drives[k].duty[static_cast<std::size_t>(i)] = 0;
    }
    return drives;
}

ArrayOutput::ArrayOutput(const Open& open,
                         base::MessageLog& messages,
                         double retry_s,
                         const base::Clock& clock) :
    _messages(messages),
    _clock(clock)
{
    _opener = std::make_unique<DeviceOpener>(open, retry_s);
    _shared.isOpening = !_opener->await();
    if (takeDevice()) return;
    if (!_shared.isOpening)
    {
        if (retry_s <= 0.0) _opener.reset();
        return;
    }
    const std::string why =
        fmt::format("device: opening it takes longer than {:g} s; it plays once it is open",
                    DeviceOpener::kPatience_s);
    _messages.say({base::MessageCode::DEVICE_OPEN, why});
    const base::Lock lock(_shared.mutex);
    _shared.openError = why;
}

ArrayOutput::~ArrayOutput()
{
    silenceNow();
}

void ArrayOutput::follow(const std::shared_ptr<device::Lead>& lead)
{
    const base::Lock lock(_sending);
    lead->setAmplitudeCap(_lead->amplitudeCap());
    if (_lead->isMuted()) lead->setMuted(true);
    _lead = lead;
    if (!_device) return;
    _device->follow(lead);
    if (lead->isMuted()) _device->setMuted(true);
}

device::DriveAbility ArrayOutput::ability() const
{
    return device() ? device()->ability() : device::DriveAbility();
}

void ArrayOutput::play(std::vector<device::DriveSignal> drives,
                       const haptics::ModulatorOptions& modulation,
                       const base::StopToken& stop)
{
    _given = {std::move(drives), modulation};
    _shared.sounds = std::any_of(_given.drives.begin(), _given.drives.end(), isAnything);
    _sent.isPlaying = true;
    if (!device()) _shared.isCutOff = false;
    usePlayer(_given.drives.size() > 1 || modulation.amplitudeRate_Hz > 0.0);
    if (_sent.byPlayer)
        startPlayer(stop);
    else if (device() && !sendHeld(stop) && !isBlocked() && !isHoldOver())
        tellRefusal(device()->report());
    const base::Topic cap{base::MessageCode::DEVICE_CAP};
    if (_messages.begins(cap, _shared.isUncapped))
        _messages.say(cap,
                      {base::MessageCode::DEVICE_CAP,
                       "the device can't apply an amplitude cap; nothing is played"});
}

void ArrayOutput::noteSending()
{
    _shared.isCutOff = false;
    _sent.mutes = _lead->mutes();
    if (_lead->isMuted()) _sent.mutes = kNever;
}

// Caps are already applied. If the device refuses a step, the next one follows anyway.
bool ArrayOutput::startPlayer(const base::StopToken& stop)
{
    const base::Lock lock(_sending);
    stop.throwIfRequested();
    noteSending();
    _sent.isPlaying = !isBlocked();
    if (_sent.isPlaying) _player->play(_given.drives, _given.modulation);
    return _sent.isPlaying;
}

// The player and its thread exist only while fields change with time.
void ArrayOutput::usePlayer(bool wanted)
{
    const base::Lock lock(_sending);
    if (!wanted)
        _player.reset();
    else if (!_player && _device)
        _player = std::make_unique<FieldPlayer>(*_device, _clock);
    _sent.byPlayer = _player != nullptr;
    if (_player) _sent.isHeld = false;
}

bool ArrayOutput::sendHeld(const base::StopToken& stop)
{
    const base::Lock lock(_sending);
    stop.throwIfRequested();
    noteSending();
    _sent.before = _device->report();
    _sent.time_s = _clock.now_s();
    _sent.isPlaying = false;
    _sent.isHeld = true; // until it is unmuted, or capped
    if (isBlocked()) return false;
    _sent.isPlaying = _device->sendUnled(_given.drives.front());
    // A READY device that refuses a field would refuse it again: attend() doesn't retry.
    _sent.isHeld =
        _sent.isPlaying || isHoldOver() || _device->report().state != device::DeviceState::READY;
    if (!_sent.isPlaying) _device->silence();
    return _sent.isPlaying;
}

// The report's message says what happened to the device.
base::Message ArrayOutput::refusal(const device::DeviceReport& report) const
{
    using base::MessageCode;
    if (report.state == device::DeviceState::MUTED)
        return {MessageCode::DEVICE_MUTED, "device: muted"};
    const std::string why = report.message.empty() ? device()->status() : report.message;
    if (report.state == device::DeviceState::LOST)
        return {MessageCode::DEVICE_LOST, "device: lost: " + why};
    if (report.state == device::DeviceState::HANGING)
        return {MessageCode::DEVICE_HANGS, "device: hangs: " + why};
    return {MessageCode::DEVICE_REFUSED, "device refused a field: " + why};
}

// A loss is reported once; all fields that it costs count as refused.
void ArrayOutput::tellRefusal(const device::DeviceReport& report)
{
    if (report.state == device::DeviceState::HANGING && !report.unsilenced.empty())
    {
        tellOfDriver();
        return;
    }
    const base::Message why = refusal(report);
    const bool isLoss =
        why.code == base::MessageCode::DEVICE_LOST || why.code == base::MessageCode::DEVICE_HANGS;
    if (isLoss && _toldLoss == report.reconnects) return;
    if (isLoss) _toldLoss = report.reconnects;
    _messages.say(why);
}

void ArrayOutput::tell(ArrayState state)
{
    const base::Topic fault{base::MessageCode::DEVICE_FAULT};
    if (state != ArrayState::FAULT) _messages.ends(fault);
    if (state != ArrayState::LOST && state != ArrayState::FAULT) return;
    const device::DeviceReport report = device()->report();
    if (report.state >= device::DeviceState::HANGING) return tellRefusal(report);
    if (state == ArrayState::LOST) return; // it is back already
    if (!_sent.isPlaying) return;
    _messages.begins(fault);
    _messages.say(fault,
                  {base::MessageCode::DEVICE_FAULT,
                   fmt::format("device: accepts fields but doesn't play them: of {} fields {} were "
                               "played and {} lost{}{}",
                               report.sent,
                               report.played,
                               report.lost,
                               report.message.empty() ? "" : "; ",
                               report.message)});
}

bool ArrayOutput::tellOfDriver()
{
    if (!device()) return false;
    const device::DeviceReport report = device()->report();
    const auto tells = [this](const char* what, base::MessageCode code, const std::string& text)
    {
        const base::Topic topic{code, 0, what};
        const bool isNew = _messages.begins(topic, !text.empty());
        if (isNew) _messages.say(topic, {code, "device: " + text});
        return isNew;
    };
    const bool isQuieted = tells("quieted", base::MessageCode::DEVICE_FAULT, report.quieted);
    const bool mayPlayOn = tells("unsilenced", base::MessageCode::DEVICE_FAULT, report.unsilenced);
    const bool complains = tells("complaint", base::MessageCode::CALLBACK_THREW, report.complaint);
    // It may have been at fault before; then its state doesn't change.
    const bool hangs = report.state == device::DeviceState::HANGING && report.unsilenced.empty() &&
                       _toldLoss != report.reconnects;
    if (hangs) tellRefusal(report);
    return isQuieted || mayPlayOn || complains || hangs;
}

void ArrayOutput::endWhatIsOver()
{
    if (!device()) return;
    using base::MessageCode;
    const device::DeviceState state = device()->report().state;
    if (state != device::DeviceState::MUTED) _messages.end(MessageCode::DEVICE_MUTED);
    if (state != device::DeviceState::HANGING) _messages.end(MessageCode::DEVICE_HANGS);
    if (state != device::DeviceState::READY) return;
    _messages.end(MessageCode::DEVICE_LOST);
    if (_sent.isPlaying) _messages.end(MessageCode::DEVICE_REFUSED);
}

void ArrayOutput::silence(Silence why)
{
    _sent.isHeld = false;
    _sent.isPlaying = why == Silence::WANTED;
    _given.drives.clear();
    _shared.sounds = false; // reset first, because a concurrent reading() would take it as played
    silenceNow();
    _shared.isCutOff = false;
}

void ArrayOutput::silenceNow()
{
    const base::Lock lock(_sending);
    _shared.isCutOff = true;
    if (_player) _player->stop(); // otherwise its next step would end the silence
    if (_device) _device->silence();
}

void ArrayOutput::setAmplitudeCap(double amplitude)
{
    const base::Lock lock(_sending);
    keepCap(amplitude);
}

void ArrayOutput::lowerAmplitudeCap(double amplitude)
{
    const base::Lock lock(_sending);
    if (!(amplitude >= _lead->amplitudeCap())) keepCap(amplitude);
}

void ArrayOutput::keepCap(double amplitude)
{
    _lead->setAmplitudeCap(amplitude);
    if (!_device) return;
    _shared.isUncapped = !_device->setAmplitudeCap(amplitude);
    if (!_shared.isUncapped) return;
    if (_player) _player->stop();
    _device->silence();
}

void ArrayOutput::setMuted(bool muted)
{
    const base::Lock lock(_sending);
    _lead->setMuted(muted);
    if (_player && muted) _player->stop(); // otherwise it would count refused steps
    if (_device) _device->setMuted(muted);
}

ArrayOutput::Attention ArrayOutput::attend(const base::StopToken& stop)
{
    if (!device() || _given.drives.empty()) return Attention::NOTHING;
    if (isBlocked() || isMutedAway()) _sent.isPlaying = false;
    if (isBlocked() || isHoldOver()) return Attention::NOTHING;
    // The player sends its steps again by itself, unless it was stopped for a mute.
    if (_sent.byPlayer)
        return !_sent.isPlaying && startPlayer(stop) ? Attention::RESENT : Attention::NOTHING;
    if (!_sent.isHeld) return Attention::NOTHING;
    const device::DeviceReport now = device()->report();
    const device::DeviceReport& before = _sent.before;
    const bool ready = now.state == device::DeviceState::READY;
    if (isCutShort()) _sent.isPlaying = false;
    // Losses before a reconnect say nothing about the device that came back.
    const bool wasAway = now.reconnects != before.reconnects;
    const bool lost = wasAway || now.lost != before.lost || now.faults != before.faults;
    const bool again = ready && now.pending == 0 && (lost || !_sent.isPlaying);
    if (!again && (ready || !_sent.isPlaying)) return Attention::NOTHING;
    if (ready && !wasAway && now.lost != before.lost && now.played == before.played)
    {
        _faithfulness.isMissed = true;
        _faithfulness.playedAtMiss = now.played;
    }
    _sent.isPlaying = false;
    if (again && sendHeld(stop)) return Attention::RESENT;
    tellRefusal(device()->report());
    return Attention::REFUSED;
}

Eigen::VectorXcf ArrayOutput::wouldPlay(const device::DriveSignal& signal) const
{
    if (device()) return vectorOf(device()->wouldPlay(signal));
    std::vector<std::complex<float>> q;
    device::decode(signal, q);
    return vectorOf(q);
}

std::vector<Eigen::VectorXcf> ArrayOutput::played() const
{
    const std::size_t count = _given.drives.size();
    if (device() && isBlocked())
        return std::vector<Eigen::VectorXcf>(count, vectorOf(device()->played()));
    // Fields in transit count as played, unless the device has just lost the same field.
    const auto comes = [this]
    {
        return _sent.isPlaying &&
               (_sent.byPlayer || (!_faithfulness.isMissed && device()->report().pending > 0));
    };
    const bool told = device() && !comes();
    if (told && count == 1) return {vectorOf(device()->played())};
    return planned();
}

std::vector<Eigen::VectorXcf> ArrayOutput::planned() const
{
    std::vector<Eigen::VectorXcf> fields;
    fields.reserve(_given.drives.size());
    for (const device::DriveSignal& drive : _given.drives)
        fields.push_back(wouldPlay(drive));
    return fields;
}

// State and history of an ArrayOutput's device: for messages, counters and programs.

// Changes of the application meanwhile (mute, cap) apply from the first field on.
bool ArrayOutput::tryAgain()
{
    if (!_opener || !takeDevice()) return false;
    _messages.end(base::MessageCode::DEVICE_OPEN);
    _messages.say({base::MessageCode::DEVICE_OPENED,
                   "device: open now, after it could not be opened at first"});
    return true;
}

// Returns false if the device is not open yet; reports failed tries.
bool ArrayOutput::takeDevice()
{
    std::uint64_t failed = 0;
    std::string why;
    auto device = _opener->take(failed, why);
    if (failed > 0)
    {
        _shared.isOpening = false;
        base::Message again(base::MessageCode::DEVICE_OPEN, why);
        again.count = failed;
        _messages.say(std::move(again));
        const base::Lock lock(_shared.mutex);
        _shared.openError = why;
    }
    if (!device) return false;
    _opener.reset();
    _shared.isOpening = false;
    const base::Lock lock(_sending);
    _device = std::move(device);
    _device->follow(_lead);
    if (_lead->isMuted()) _device->setMuted(true);
    keepCap(_lead->amplitudeCap());
    _sent.isPlaying = _sent.isHeld = false;
    _sent.before = _device->report();
    _faithfulness.share = {};
    _shared.device = _device.get();
    return true;
}

ArrayState ArrayOutput::state()
{
    if (!device()) return _shared.isOpening ? ArrayState::OPENING : ArrayState::CLOSED;
    const device::DeviceReport report = device()->report();
    Faithfulness& faith = _faithfulness;
    if (faith.isMissed && report.played > faith.playedAtMiss) faith.isMissed = false;
    // Once a field is held, the losses of a moving scene's fields no longer matter.
    const bool isHeld =
        !_sent.byPlayer && report.pending == 0 && report.played > _sent.before.played;
    if (isHeld && _clock.now_s() - _sent.time_s > kRest_s) faith.share.forget(report);
    const bool isFaulty = faith.share.isFaulty(report) || faith.isMissed;
    if (report.state < device::DeviceState::HANGING) _toldLoss.reset();
    if (report.state == device::DeviceState::HANGING) return ArrayState::FAULT;
    if (report.state == device::DeviceState::LOST) return ArrayState::LOST;
    if (!report.unsilenced.empty()) return ArrayState::FAULT; // even if muted: it may sound
    if (_lead->isMuted() || report.state == device::DeviceState::MUTED) return ArrayState::MUTED;
    if (!report.quieted.empty()) return ArrayState::FAULT;
    if (_given.drives.empty() || _shared.isCutOff || isHoldOver() || isCutShort())
        return ArrayState::SILENT;
    const bool isPlayedAgain =
        !_shared.isUncapped && (_sent.isHeld || _sent.byPlayer); // by attend()
    if (isMutedAway() && isPlayedAgain) return ArrayState::MUTED;
    return _sent.isPlaying && !isFaulty ? ArrayState::PLAYING : ArrayState::FAULT;
}

bool ArrayOutput::isHoldOver() const
{
    return device() && device()->isHoldOver();
}

// Silenced by the device itself: it got no sign of life or didn't confirm a quieter field.
bool ArrayOutput::isCutShort() const
{
    const bool isOwn =
        device() && _sent.isHeld && !_shared.isCutOff && !isMutedAway() && !isBlocked();
    return isOwn && device()->report().silences != _sent.before.silences;
}

void ArrayOutput::judge(ArrayState state)
{
    if (!device()) return;
    const std::uint64_t played = device()->report().played;
    const base::Lock lock(_shared.mutex);
    _shared.judged = {state, played};
}

ArrayReading ArrayOutput::reading() const
{
    ArrayReading now;
    const device::ArrayDevice* device = _shared.device;
    if (!device)
    {
        if (_shared.isOpening) now.state = ArrayState::OPENING;
        const base::Lock lock(_shared.mutex);
        now.status = "not open: " + _shared.openError;
        return now;
    }
    Judgement judged;
    {
        const base::Lock lock(_shared.mutex);
        judged = _shared.judged;
    }
    const device::DeviceReport report = device->report();
    now.fields = fieldsOf(report);
    now.status = device->status();
    const bool isMuted = _lead->isMuted() || report.state == device::DeviceState::MUTED;
    // It may have played silence.
    const bool hasPlayed =
        sounds() && judged.state != ArrayState::FAULT && report.played > judged.played;
    // Even if muted: it may sound.
    const bool hangs = report.state == device::DeviceState::HANGING || !report.unsilenced.empty();
    // Silenced since the judgement, by another thread or by its hold.
    const bool isSilenced = _shared.isCutOff || !sounds() || device->isHoldOver();
    const bool mayPlay = hasPlayed || judged.state == ArrayState::PLAYING;
    now.state = report.state == device::DeviceState::LOST ? ArrayState::LOST
                : hangs                                   ? ArrayState::FAULT
                : isMuted                                 ? ArrayState::MUTED
                : !report.quieted.empty()                 ? ArrayState::FAULT
                : mayPlay && isSilenced                   ? ArrayState::SILENT
                : hasPlayed                               ? ArrayState::PLAYING
                                                          : judged.state;
    return now;
}

PlayedDrives ArrayOutput::playedOfLate(double duration_s) const
{
    return device() ? playedOf(*device(), duration_s) : PlayedDrives();
}

} // namespace midair::bridge
