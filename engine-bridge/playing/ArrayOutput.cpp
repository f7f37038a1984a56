#include "engine-bridge/playing/ArrayOutput.h"

#include "device/drive/DriveEncoder.h"

#include <complex>
#include <stdexcept>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

Eigen::VectorXcf vectorOf(const std::vector<std::complex<float>>& q)
{
    return Eigen::Map<const Eigen::VectorXcf>(q.data(), static_cast<Eigen::Index>(q.size()));
}

std::vector<device::DriveSignal> encoded(const haptics::FieldSequence& sequence, int transducers)
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
    }
    return signals;
}

} // namespace

ArrayOutput::ArrayOutput(const Open& open, base::MessageLog& messages) : _messages(messages)
{
    try
    {
        _device = open();
    }
    catch (const std::exception& error)
    {
        _openError = error.what();
        _messages.say(_openError);
    }
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
    _signals = encoded(sequence, transducers);
    _playing = true;
    usePlayer(sequence.changes());
    if (_player)
    {
        const std::lock_guard<std::mutex> lock(_sending);
        stop.throwIfRequested();
        // The fields are capped already. If the device refuses a step, the next one follows anyway.
        _player->play(_signals, sequence.modulation);
    }
    else if (_device && !sendHeld(stop))
        _messages.say(refusal());
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
    _before = _device->report();
    _playing = _device->send(_signals.front());
    // A device that is READY and refuses the field would refuse it again: attend() doesn't retry.
    _holds = _playing || _device->report().state != device::DeviceState::READY;
    if (!_playing) _device->silence();
    return _playing;
}

// The report's message says what happened to the device; the log takes it once.
std::string ArrayOutput::refusal() const
{
    const device::DeviceReport report = _device->report();
    if (report.state == device::DeviceState::MUTED) return "device: muted";
    const std::string why = report.message.empty() ? _device->status() : report.message;
    return (report.state == device::DeviceState::LOST ? "device: " : "device refused a field: ") +
           why;
}

void ArrayOutput::silence(Silence why)
{
    _holds = false;
    _playing = why == Silence::WANTED;
    _signals.clear();
    silenceNow();
}

void ArrayOutput::silenceNow()
{
    const std::lock_guard<std::mutex> lock(_sending);
    if (_player) _player->stop(); // or its next step would end the silence
    if (_device) _device->silence();
}

ArrayOutput::Attention ArrayOutput::attend(const base::StopToken& stop)
{
    // The player sends its steps again by itself.
    if (!_device || _player || !_holds) return Attention::NOTHING;
    const device::DeviceReport now = _device->report();
    const bool ready = now.state == device::DeviceState::READY;
    const bool lost = now.lost != _before.lost || now.faults != _before.faults ||
                      now.reconnects != _before.reconnects;
    const bool again = ready && now.pending == 0 && (lost || !_playing);
    if (!again && (ready || !_playing)) return Attention::NOTHING;
    _playing = false;
    if (again && sendHeld(stop)) return Attention::RESENT;
    _messages.say(refusal());
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
    const bool told = _device && !(_playing && (_player || _device->report().pending > 0));
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

std::string ArrayOutput::status() const
{
    return _device ? _device->status() : "not open: " + _openError;
}

} // namespace midair::bridge
