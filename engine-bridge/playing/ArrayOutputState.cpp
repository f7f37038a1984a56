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
    // What a moving scene's fields became says nothing more once one of them is held.
    const bool isHeld =
        !_sent.byPlayer && report.pending == 0 && report.played > _sent.before.played;
    if (isHeld && base::steadySeconds() - _sent.time_s > kRest_s) faith.share.forget(report);
    const bool isFaulty = faith.share.isFaulty(report) || faith.isMissed;
    if (report.state < device::DeviceState::HANGING) _told.loss.reset();
    if (report.state == device::DeviceState::HANGING) return ArrayState::FAULT;
    if (report.state == device::DeviceState::LOST) return ArrayState::LOST;
    if (_lead->isMuted() || report.state == device::DeviceState::MUTED) return ArrayState::MUTED;
    if (!report.quieted.empty() || !report.unsilenced.empty()) return ArrayState::FAULT;
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

// By the device itself, which has lost its sign of life or has not confirmed a quieter field.
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
        now.status = "not open: " + openError();
        if (_shared.isOpening) now.state = ArrayState::OPENING;
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
    // What it has played may be silence.
    const bool hasPlayed =
        sounds() && judged.state != ArrayState::FAULT && report.played > judged.played;
    // Muted or not: it may sound.
    const bool hangs = report.state == device::DeviceState::HANGING || !report.unsilenced.empty();
    // Silenced since it was judged, by another thread or by its hold.
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

std::string ArrayOutput::openError() const
{
    const base::Lock lock(_shared.mutex);
    return _shared.openError;
}

std::string ArrayOutput::status() const
{
    return device() ? device()->status() : "not open: " + openError();
}

} // namespace midair::bridge
