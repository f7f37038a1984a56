// What an ArrayOutput's device does and has done: for messages, counters and programs.
#include "engine-bridge/playing/ArrayOutput.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <utility>

namespace midair::bridge
{

namespace
{

constexpr double kRest_s = 0.2; // a field that is held for longer is that of a scene at rest

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

// What the application does about it meanwhile (mute, cap) holds from the first field on.
bool ArrayOutput::tryAgain()
{
    if (!_opener || !takeDevice()) return false;
    _messages.say({base::MessageCode::DEVICE_OPENED,
                   "device: open now, after it could not be opened at first"});
    return true;
}

// Returns false if the device is not open yet, and tells of the tries that have failed.
bool ArrayOutput::takeDevice()
{
    std::uint64_t failed = 0;
    std::string why;
    auto device = _opener->take(failed, why);
    if (failed > 0) _isOpening = false;
    if (failed > 0)
    {
        base::Message again(base::MessageCode::DEVICE_OPEN, why);
        again.count = failed;
        _messages.say(std::move(again));
        const std::lock_guard<std::mutex> lock(_telling);
        _openError = why;
    }
    if (!device) return false;
    _opener.reset();
    _isOpening = false;
    {
        const std::lock_guard<std::mutex> lock(_sending);
        _device = std::move(device);
        if (_muted) _device->setMuted(true);
        keepCap(_cap);
        _playing = _holds = false;
        _share = {};
        _before = _device->report();
    }
    _opened = _device.get();
    _device->noteSign(_sign_s); // that it was opened is none
    return true;
}

ArrayState ArrayOutput::state()
{
    if (!_device) return _isOpening ? ArrayState::OPENING : ArrayState::CLOSED;
    const device::DeviceReport report = _device->report();
    if (_missed && report.played > _playedAtMiss) _missed = false;
    // What a moving scene's fields became says nothing more once one of them is held.
    const bool isHeld = !_player && report.pending == 0 && report.played > _before.played;
    if (isHeld && base::steadySeconds() - _sent_s > kRest_s) _share.forget(report);
    const bool isFaulty = _share.isFaulty(report) || _missed;
    if (report.state < device::DeviceState::HANGING) _toldLoss.reset();
    if (report.state == device::DeviceState::HANGING) return ArrayState::FAULT;
    if (report.state == device::DeviceState::LOST) return ArrayState::LOST;
    if (_muted || report.state == device::DeviceState::MUTED) return ArrayState::MUTED;
    if (!report.quieted.empty() || !report.unsilenced.empty()) return ArrayState::FAULT;
    if (_signals.empty() || _isCutOff || isHoldOver() || isCutShort()) return ArrayState::SILENT;
    const bool isPlayedAgain = !_uncapped && (_holds || _player); // by attend()
    if (_isMutedAway && isPlayedAgain) return ArrayState::MUTED;
    return _playing && !isFaulty ? ArrayState::PLAYING : ArrayState::FAULT;
}

void ArrayOutput::keepAlive()
{
    noteSign(base::steadySeconds());
}

void ArrayOutput::noteSign(double at_s)
{
    _sign_s = at_s;
    if (device::ArrayDevice* device = _opened) device->noteSign(at_s);
}

bool ArrayOutput::isHoldOver() const
{
    const device::ArrayDevice* device = _opened;
    return device && device->isHoldOver();
}

// By the device itself, which has lost its sign of life or has not confirmed a quieter field.
bool ArrayOutput::isCutShort() const
{
    const bool isOwn = _device && _holds && !_isCutOff && !_isMutedAway && !isBlocked();
    return isOwn && _device->report().silences != _before.silences;
}

void ArrayOutput::judge(ArrayState state)
{
    if (!_device) return;
    const std::uint64_t played = _device->report().played;
    const std::lock_guard<std::mutex> lock(_telling);
    _judged = {state, played};
}

ArrayReading ArrayOutput::reading() const
{
    ArrayReading now;
    const device::ArrayDevice* device = _opened;
    if (!device)
    {
        now.status = "not open: " + openError();
        if (_isOpening) now.state = ArrayState::OPENING;
        return now;
    }
    Judgement judged;
    {
        const std::lock_guard<std::mutex> lock(_telling);
        judged = _judged;
    }
    const device::DeviceReport report = device->report();
    now.fields = fieldsOf(report);
    now.status = device->status();
    const bool isMuted = _muted || report.state == device::DeviceState::MUTED;
    // What it has played may be silence.
    const bool hasPlayed =
        sounds() && judged.state != ArrayState::FAULT && report.played > judged.played;
    // Muted or not: it may sound.
    const bool hangs = report.state == device::DeviceState::HANGING || !report.unsilenced.empty();
    // Silenced since it was judged, by another thread or by its hold.
    const bool isSilenced = _isCutOff || !sounds() || device->isHoldOver();
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
    const device::ArrayDevice* device = _opened;
    return device ? playedOf(*device, duration_s) : PlayedDrives();
}

std::string ArrayOutput::openError() const
{
    const std::lock_guard<std::mutex> lock(_telling);
    return _openError;
}

std::string ArrayOutput::status() const
{
    const device::ArrayDevice* device = _opened;
    return device ? device->status() : "not open: " + openError();
}

} // namespace midair::bridge
