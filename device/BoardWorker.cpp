// The worker of BoardDevice: the only one that writes.

#include "device/BoardDevice.h"

#include <algorithm>

#include <spdlog/spdlog.h>

namespace midair::device
{

namespace
{

constexpr double kReconnect_s = 0.25;
constexpr double kRepeat_s = 0.2; ///< and at least every other frame is free for what is new
constexpr double kLook_s = 0.05;  ///< signs of life, and whether the line is still there

std::chrono::duration<double> seconds(double s)
{
    return std::chrono::duration<double>(s);
}

} // namespace

void BoardDevice::run()
{
    std::unique_lock<std::mutex> lock(_mutex);
    while (!_closing || !quiet())
    {
        if (_sink == nullptr)
            reconnect(lock);
        else if (steadySeconds() - _lookedAfter_s >= kLook_s)
            lookAfterLine(lock);
        else if (const double due_s = nextWrite_s(), wait_s = due_s - steadySeconds(); wait_s > 0)
            _wake.wait_for(
                lock, seconds(std::min(wait_s, kLook_s)), [&] { return nextWrite_s() < due_s; });
        else
            writeNext(lock);
    }
}

bool BoardDevice::quiet() const
{
    return _sink == nullptr ||
           (!_resetDue && !_silenceWanted && _silentLeft == 0 && steadySeconds() >= _lineFree_s);
}

void BoardDevice::reconnect(std::unique_lock<std::mutex>& lock)
{
    _wake.wait_for(lock, seconds(kReconnect_s), [&] { return _closing; });
    if (_closing) return;
    std::unique_ptr<ByteSink> sink;
    lock.unlock();
    try
    {
        sink = _open(_reset);
    }
    catch (const DeviceError&)
    {
        // what is wrong was said when it was lost
    }
    lock.lock();
    if (sink != nullptr) adopt(std::move(sink));
}

void BoardDevice::adopt(std::unique_ptr<ByteSink> sink)
{
    _settled_s = sink->settled_s();
    _sink = std::move(sink);
    _resetDue = true;
    _lookedAfter_s = 0;
}

void BoardDevice::lookAfterLine(std::unique_lock<std::mutex>& lock)
{
    _lookedAfter_s = steadySeconds();
    _sink->beat();
    if (!_sink->present()) lose(lock, _sink->error());
}

// What is in the operating system's buffer can't be overtaken, so the line has to be free; unless a field may be cut off.
double BoardDevice::nextWrite_s() const
{
    if (_resetDue) return _settled_s;
    if (_silenceWanted && _codec->restarts()) return 0;
    if (_silenceWanted || _slotFull || _silentLeft > 0 || _closing) return _lineFree_s;
    return _repeatAt_s;
}

BoardDevice::Piece BoardDevice::nextPiece()
{
    Piece piece;
    piece.epoch = _epoch;
    _bytes.clear();
    if (_resetDue)
    {
        piece.kind = Piece::RESET;
        piece.field = _silentField;
        _bytes = _reset;
        _openingAt_s = steadySeconds();
        return piece;
    }
    if (_silenceWanted || (!_slotFull && _silentLeft > 0))
    {
        piece.kind = Piece::SILENCE;
        piece.field = _silentField;
    }
    else if (_slotFull)
    {
        piece.kind = Piece::FIELD;
        piece.signal = std::move(_slot);
        piece.sentAt_s = _slotAt_s;
        _slotFull = false;
        _codec->appendField(piece.field, piece.signal);
    }
    else
        piece.field = _current;
    const double now_s = steadySeconds();
    if (piece.kind != Piece::FIELD || now_s - _openingAt_s >= kRepeat_s)
    {
        _codec->appendOpening(_bytes);
        _openingAt_s = now_s;
    }
    _bytes.insert(_bytes.end(), piece.field.begin(), piece.field.end());
    return piece;
}

void BoardDevice::writeNext(std::unique_lock<std::mutex>& lock)
{
    const bool overtakes = !_resetDue && _silenceWanted && _codec->restarts();
    Piece piece = nextPiece();
    lock.unlock();
    if (overtakes) _sink->discard();
    const bool written = _sink->write(_bytes);
    lock.lock();
    if (written)
    {
        finish(std::move(piece));
        return;
    }
    if (piece.kind == Piece::FIELD) _counters.change([](DeviceReport& report) { ++report.lost; });
    lose(lock, _sink->error());
}

void BoardDevice::finish(Piece piece)
{
    const double now_s = steadySeconds();
    const double onLine_s = static_cast<double>(_bytes.size()) / _codec->bytesPerSecond();
    _lineFree_s = now_s + onLine_s;
    _repeatAt_s = now_s + std::max(kRepeat_s, 2 * onLine_s);
    const bool newest = piece.epoch == _epoch;
    switch (piece.kind)
    {
    case Piece::RESET:
        _resetDue = false;
        _silenceWanted = _silenceWanted && !newest;
        _silentLeft = 0;
        if (!_ready && _counters.report().state == DeviceState::LOST)
        {
            _ready = true;
            std::fill(_playing.duty.begin(), _playing.duty.end(), std::uint8_t(0));
            _counters.change(
                [](DeviceReport& report)
                {
                    report.state = DeviceState::READY;
                    ++report.reconnects;
                });
            spdlog::info("{}: back, and silenced until the next field", _name);
        }
        break;
    case Piece::SILENCE:
        if (!newest) break;
        _silentLeft = _silenceWanted ? _codec->silentFields() - 1 : std::max(0, _silentLeft - 1);
        _silenceWanted = false;
        break;
    case Piece::FIELD:
        _silentLeft = 0; // the buffers hold silence and this field
        _counters.change(
            [&](DeviceReport& report)
            {
                ++report.played;
                report.lastHandedOver_s = now_s;
                report.latency_s = now_s - piece.sentAt_s;
            });
        if (newest) _playing = std::move(piece.signal);
        break;
    case Piece::REPEAT:
        break;
    }
    if (piece.kind != Piece::REPEAT) _current = std::move(piece.field);
}

// Whoever still can writes silence: this program, and where it can't, the guard, which is not sent away but told to act.
void BoardDevice::lose(std::unique_lock<std::mutex>& lock, std::string why)
{
    const bool settled = !_resetDue || steadySeconds() >= _settled_s;
    std::unique_ptr<ByteSink> sink = std::move(_sink);
    const bool first = _ready;
    _ready = false;
    _silenceWanted = false;
    _resetDue = false;
    _silentLeft = 0;
    _counters.change(
        [&](DeviceReport& report)
        {
            report.state = DeviceState::LOST;
            report.dropped += _slotFull ? 1 : 0;
            ++report.faults;
            report.message = why;
        });
    _slotFull = false;
    lock.unlock();
    bool silenced = false;
    if (settled && sink->present())
    {
        sink->discard();
        silenced = sink->write(_reset);
    }
    silenced = silenced || sink->bequeath();
    sink.reset();
    lock.lock();
    why += silenced ? "; silence was written to the board once more, but it doesn't say whether it "
                      "got it: if it still plays, cut its power"
                    : "; the board may still play what it had, for it has no watchdog: cut its "
                      "power";
    if (silenced) std::fill(_playing.duty.begin(), _playing.duty.end(), std::uint8_t(0));
    _counters.change([&](DeviceReport& report) { report.message = why; });
    if (first) spdlog::error("{}: {}", _name, why);
}

} // namespace midair::device
