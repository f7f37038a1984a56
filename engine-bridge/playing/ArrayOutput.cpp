#include "engine-bridge/playing/ArrayOutput.h"

#include "device/drive/DriveEncoder.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <complex>
#include <cstdint>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

Eigen::VectorXcf vectorOf(const std::vector<std::complex<float>>& q)
{
    return Eigen::Map<const Eigen::VectorXcf>(q.data(), static_cast<Eigen::Index>(q.size()));
}

bool isAnything(const device::DriveSignal& drive)
{
    return std::any_of(
        drive.duty.begin(), drive.duty.end(), [](std::uint8_t duty) { return duty > 0; });
}

} // namespace

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

ArrayOutput::ArrayOutput(const Open& open, base::MessageLog& messages, double retry_s) :
    _messages(messages)
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
    if (_shared.isUncapped && !std::exchange(_told.uncapped, true))
        _messages.say({base::MessageCode::DEVICE_CAP,
                       "the device can't keep a cap of its amplitude; nothing is played"});
}

void ArrayOutput::noteSending()
{
    _shared.isCutOff = false;
    _sent.mutes = _lead->mutes();
    if (_lead->isMuted()) _sent.mutes = kNever;
}

// The fields are capped already. If the device refuses a step, the next one follows anyway.
bool ArrayOutput::startPlayer(const base::StopToken& stop)
{
    const base::Lock lock(_sending);
    stop.throwIfRequested();
    noteSending();
    _sent.isPlaying = !isBlocked();
    if (_sent.isPlaying) _player->play(_given.drives, _given.modulation);
    return _sent.isPlaying;
}

// The player, and so its thread, exists only while fields change with time.
void ArrayOutput::usePlayer(bool wanted)
{
    const base::Lock lock(_sending);
    if (!wanted)
        _player.reset();
    else if (!_player && _device)
        _player = std::make_unique<FieldPlayer>(*_device);
    _sent.byPlayer = _player != nullptr;
    if (_player) _sent.isHeld = false;
}

bool ArrayOutput::sendHeld(const base::StopToken& stop)
{
    const base::Lock lock(_sending);
    stop.throwIfRequested();
    noteSending();
    _sent.before = _device->report();
    _sent.time_s = base::steadySeconds();
    _sent.isPlaying = false;
    _sent.isHeld = true; // until it is unmuted, or capped
    if (isBlocked()) return false;
    _sent.isPlaying = _device->sendUnled(_given.drives.front());
    // A device that is READY and refuses the field would refuse it again: attend() doesn't retry.
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

// A loss is told once, however many fields it costs: these are counted as refused.
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
    if (isLoss && _told.loss == report.reconnects) return;
    if (isLoss) _told.loss = report.reconnects;
    _messages.say(why);
}

void ArrayOutput::tell(ArrayState state)
{
    if (state != ArrayState::LOST && state != ArrayState::FAULT) return;
    const device::DeviceReport report = device()->report();
    if (report.state >= device::DeviceState::HANGING) return tellRefusal(report);
    if (state == ArrayState::LOST) return; // it is back already
    if (!_sent.isPlaying) return;
    _messages.say(
        {base::MessageCode::DEVICE_FAULT,
         fmt::format("device: takes what it is sent and doesn't play it: of {} fields {} were "
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
    const auto isNew = [](const std::string& text, bool& isTold)
    { return !std::exchange(isTold, !text.empty()) && isTold; };
    const bool isQuieted = isNew(report.quieted, _told.quieted);
    if (isQuieted) _messages.say({base::MessageCode::DEVICE_FAULT, "device: " + report.quieted});
    const bool mayPlayOn = isNew(report.unsilenced, _told.unsilenced);
    if (mayPlayOn) _messages.say({base::MessageCode::DEVICE_FAULT, "device: " + report.unsilenced});
    const bool complains = isNew(report.complaint, _told.complaint);
    if (complains)
        _messages.say({base::MessageCode::CALLBACK_THREW, "device: " + report.complaint});
    // It may have been at fault before, so that its state doesn't change.
    const bool hangs = report.state == device::DeviceState::HANGING && report.unsilenced.empty() &&
                       _told.loss != report.reconnects;
    if (hangs) tellRefusal(report);
    return isQuieted || mayPlayOn || complains || hangs;
}

void ArrayOutput::silence(Silence why)
{
    _sent.isHeld = false;
    _sent.isPlaying = why == Silence::WANTED;
    _given.drives.clear();
    _shared.sounds = false; // before it is judged anew, a reading would take it as played
    silenceNow();
    _shared.isCutOff = false;
}

void ArrayOutput::silenceNow()
{
    const base::Lock lock(_sending);
    _shared.isCutOff = true;
    if (_player) _player->stop(); // or its next step would end the silence
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
    if (_player && muted) _player->stop(); // it would count refused steps
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
    const bool lost = now.lost != before.lost || now.faults != before.faults ||
                      now.reconnects != before.reconnects;
    const bool again = ready && now.pending == 0 && (lost || !_sent.isPlaying);
    if (!again && (ready || !_sent.isPlaying)) return Attention::NOTHING;
    if (ready && now.lost != before.lost && now.played == before.played)
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
    // What is on its way counts as played, unless the device has just lost the same field.
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

} // namespace midair::bridge
