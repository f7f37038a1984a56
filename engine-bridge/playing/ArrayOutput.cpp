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

std::vector<device::DriveSignal>
encoded(const haptics::FieldSequence& sequence, int transducers, const std::vector<int>& dead)
{
    std::vector<device::DriveSignal> signals(sequence.fields.size());
    for (std::size_t k = 0; k < signals.size(); ++k)
    {
        const Eigen::VectorXcf& q = sequence.fields[k];
        if (q.size() != transducers)
            throw std::runtime_error(
                fmt::format("solver gave {} activations for {} transducers; nothing is played",
                            q.size(),
                            transducers));
        if (!device::encode(q.data(), transducers, signals[k]))
            throw std::runtime_error(
                "solver gave activations that are not finite; nothing is played");
        for (const int i : dead)
            signals[k].duty[static_cast<std::size_t>(i)] = 0;
    }
    return signals;
}

} // namespace

ArrayOutput::ArrayOutput(const Open& open,
                         base::MessageLog& messages,
                         std::vector<int> dead,
                         double retry_s) :
    _messages(messages),
    _dead(std::move(dead)),
    _sign_s(base::steadySeconds())
{
    _opener = std::make_unique<DeviceOpener>(open, retry_s);
    _isOpening = !_opener->await();
    if (takeDevice()) return;
    if (!_isOpening)
    {
        if (retry_s <= 0.0) _opener.reset();
        return;
    }
    const std::lock_guard<std::mutex> lock(_telling);
    _openError =
        fmt::format("device: opening it takes longer than {:g} s; it plays once it is open",
                    DeviceOpener::kPatience_s);
    _messages.say({base::MessageCode::DEVICE_OPEN, _openError});
}

ArrayOutput::~ArrayOutput()
{
    silenceNow();
}

device::DriveAbility ArrayOutput::ability() const
{
    return _device ? _device->ability() : device::DriveAbility();
}

void ArrayOutput::play(const haptics::FieldSequence& sequence,
                       int transducers,
                       const base::StopToken& stop)
{
    _signals = encoded(sequence, transducers, _dead);
    _modulation = sequence.modulation;
    _sounds = std::any_of(_signals.begin(),
                          _signals.end(),
                          [](const device::DriveSignal& one)
                          {
                              return std::any_of(one.duty.begin(),
                                                 one.duty.end(),
                                                 [](std::uint8_t duty) { return duty > 0; });
                          });
    _playing = true;
    if (!_device) _isCutOff = false;
    usePlayer(sequence.changes());
    if (_player)
        startPlayer(stop);
    else if (_device && !sendHeld(stop) && !isBlocked() && !isHoldOver())
        tellRefusal(_device->report());
    if (_uncapped && !std::exchange(_capTold, true))
        _messages.say({base::MessageCode::DEVICE_CAP,
                       "the device can't keep a cap of its amplitude; nothing is played"});
}

// The fields are capped already. If the device refuses a step, the next one follows anyway.
bool ArrayOutput::startPlayer(const base::StopToken& stop)
{
    const std::lock_guard<std::mutex> lock(_sending);
    stop.throwIfRequested();
    _isCutOff = false;
    _playing = !isBlocked();
    _isMutedAway = _muted.load();
    if (_playing) _player->play(_signals, _modulation);
    return _playing;
}

// The player, and so its thread, exists only while fields change with time.
void ArrayOutput::usePlayer(bool wanted)
{
    const std::lock_guard<std::mutex> lock(_sending);
    if (!wanted)
        _player.reset();
    else if (!_player && _device)
        _player = std::make_unique<FieldPlayer>(*_device);
    if (_player) _holds = false;
}

bool ArrayOutput::sendHeld(const base::StopToken& stop)
{
    const std::lock_guard<std::mutex> lock(_sending);
    stop.throwIfRequested();
    _isCutOff = false;
    _before = _device->report();
    _sent_s = base::steadySeconds();
    _playing = false;
    _holds = true; // until it is unmuted, or capped
    _isMutedAway = _muted.load();
    if (isBlocked()) return false;
    _playing = _device->sendUnled(_signals.front());
    // A device that is READY and refuses the field would refuse it again: attend() doesn't retry.
    _holds = _playing || isHoldOver() || _device->report().state != device::DeviceState::READY;
    if (!_playing) _device->silence();
    return _playing;
}

// The report's message says what happened to the device.
base::Message ArrayOutput::refusal(const device::DeviceReport& report) const
{
    using base::MessageCode;
    if (report.state == device::DeviceState::MUTED)
        return {MessageCode::DEVICE_MUTED, "device: muted"};
    const std::string why = report.message.empty() ? _device->status() : report.message;
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
    if (isLoss && _toldLoss == report.reconnects) return;
    if (isLoss) _toldLoss = report.reconnects;
    _messages.say(why);
}

void ArrayOutput::tell(ArrayState state)
{
    if (state != ArrayState::LOST && state != ArrayState::FAULT) return;
    const device::DeviceReport report = _device->report();
    if (report.state >= device::DeviceState::HANGING) return tellRefusal(report);
    if (state == ArrayState::LOST) return; // it is back already
    if (!_playing) return;
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
    if (!_device) return false;
    const device::DeviceReport report = _device->report();
    const auto isNew = [](const std::string& text, bool& isTold)
    { return !std::exchange(isTold, !text.empty()) && isTold; };
    const bool isQuieted = isNew(report.quieted, _quietedTold);
    if (isQuieted) _messages.say({base::MessageCode::DEVICE_FAULT, "device: " + report.quieted});
    const bool mayPlayOn = isNew(report.unsilenced, _unsilencedTold);
    if (mayPlayOn) _messages.say({base::MessageCode::DEVICE_FAULT, "device: " + report.unsilenced});
    const bool complains = isNew(report.complaint, _complaintTold);
    if (complains)
        _messages.say({base::MessageCode::CALLBACK_THREW, "device: " + report.complaint});
    // It may have been at fault before, so that its state doesn't change.
    const bool hangs = report.state == device::DeviceState::HANGING && report.unsilenced.empty() &&
                       _toldLoss != report.reconnects;
    if (hangs) tellRefusal(report);
    return isQuieted || mayPlayOn || complains || hangs;
}

void ArrayOutput::silence(Silence why)
{
    _holds = false;
    _playing = why == Silence::WANTED;
    _signals.clear();
    _sounds = false; // before it is judged anew, a reading would take it as played
    silenceNow();
    _isCutOff = false;
}

void ArrayOutput::silenceNow()
{
    const std::lock_guard<std::mutex> lock(_sending);
    _isCutOff = true;
    if (_player) _player->stop(); // or its next step would end the silence
    if (_device) _device->silence();
}

void ArrayOutput::setAmplitudeCap(double amplitude)
{
    const std::lock_guard<std::mutex> lock(_sending);
    keepCap(amplitude);
}

void ArrayOutput::lowerAmplitudeCap(double amplitude)
{
    const std::lock_guard<std::mutex> lock(_sending);
    if (!(amplitude >= _cap)) keepCap(amplitude);
}

void ArrayOutput::keepCap(double amplitude)
{
    _cap = amplitude;
    if (!_device) return;
    _uncapped = !_device->setAmplitudeCap(amplitude);
    if (!_uncapped) return;
    if (_player) _player->stop();
    _device->silence();
}

void ArrayOutput::setMuted(bool muted)
{
    const std::lock_guard<std::mutex> lock(_sending);
    _muted = muted;
    if (muted) _isMutedAway = true;
    if (_player && muted) _player->stop(); // it would count refused steps
    if (_device) _device->setMuted(muted);
}

ArrayOutput::Attention ArrayOutput::attend(const base::StopToken& stop)
{
    if (!_device || _signals.empty()) return Attention::NOTHING;
    if (isBlocked() || _isMutedAway) _playing = false;
    if (isBlocked() || isHoldOver()) return Attention::NOTHING;
    // The player sends its steps again by itself, unless it was stopped for a mute.
    if (_player) return !_playing && startPlayer(stop) ? Attention::RESENT : Attention::NOTHING;
    if (!_holds) return Attention::NOTHING;
    const device::DeviceReport now = _device->report();
    const bool ready = now.state == device::DeviceState::READY;
    if (isCutShort()) _playing = false;
    const bool lost = now.lost != _before.lost || now.faults != _before.faults ||
                      now.reconnects != _before.reconnects;
    const bool again = ready && now.pending == 0 && (lost || !_playing);
    if (!again && (ready || !_playing)) return Attention::NOTHING;
    if (ready && now.lost != _before.lost && now.played == _before.played)
    {
        _missed = true;
        _playedAtMiss = now.played;
    }
    _playing = false;
    if (again && sendHeld(stop)) return Attention::RESENT;
    tellRefusal(_device->report());
    return Attention::REFUSED;
}

Eigen::VectorXcf ArrayOutput::wouldPlay(const device::DriveSignal& signal) const
{
    if (_device) return vectorOf(_device->wouldPlay(signal));
    std::vector<std::complex<float>> q;
    device::decode(signal, q);
    return vectorOf(q);
}

std::vector<Eigen::VectorXcf> ArrayOutput::played() const
{
    if (_device && isBlocked())
        return std::vector<Eigen::VectorXcf>(_signals.size(), vectorOf(_device->played()));
    // What is on its way counts as played, unless the device has just lost the same field.
    const auto comes = [this]
    { return _playing && (_player || (!_missed && _device->report().pending > 0)); };
    const bool told = _device && !comes();
    if (told && _signals.size() == 1) return {vectorOf(_device->played())};
    return planned();
}

std::vector<Eigen::VectorXcf> ArrayOutput::planned() const
{
    std::vector<Eigen::VectorXcf> fields;
    fields.reserve(_signals.size());
    for (const device::DriveSignal& signal : _signals)
        fields.push_back(wouldPlay(signal));
    return fields;
}

} // namespace midair::bridge
