// BoardDevice's worker thread, the only one that writes after the constructor.

#include "device/DeviceLog.h"
#include "device/SequenceNumber.h"
#include "device/boards/BoardDevice.h"

#include <algorithm>

#include <spdlog/spdlog.h>

namespace midair::device
{

namespace
{

constexpr double kReconnect_s = 0.25;
constexpr double kRepeat_s = 0.2; ///< of what plays; every other frame stays free for new fields
constexpr double kLook_s = 0.05;  ///< interval of lookAfterLine()
/// Of a sequence that is timed by the line, the line is kept busy so far ahead, which is how much a
/// silence has to overtake; this thread may wake kLate_s late.
constexpr double kAhead_s = 0.03;
constexpr double kLate_s = 0.02;
constexpr double kSwapsRepeat_s = 0.5; ///< its buffers are written again; each time it pauses
constexpr double kSwapsNew_s = 0.1;    ///< and for new fields not more often

constexpr double kClosing_s = 0.005; ///< the same while closing
constexpr double kAnswer_s = 1;      ///< a board that answers does so within five repeats

constexpr const char* kPlaysOn =
    "the board may still play what it had, for it has no watchdog: cut its power";
constexpr const char* kWasSilenced =
    "silence was written to the board once more, but it doesn't say whether it got it: if it still "
    "plays, cut its power";

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
        else if (base::steadySeconds() - _lookedAfter_s >= (_closing ? kClosing_s : kLook_s))
            lookAfterLine(lock);
        else if (const double due_s = nextWrite_s(), wait_s = due_s - base::steadySeconds();
                 wait_s > 0)
            _wake.wait_for(
                lock, seconds(std::min(wait_s, kLook_s)), [&] { return nextWrite_s() < due_s; });
        else
            writeNext(lock);
    }
}

bool BoardDevice::quiet() const
{
    return _sink == nullptr || (!_resetDue && !_silenceWanted && _silentLeft == 0 &&
                                base::steadySeconds() >= _lineFree_s && _answerDue_s == 0);
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
        // the reason was logged when it was lost
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
    _answerDue_s = 0;
    _missed = 0;
}

void BoardDevice::lookAfterLine(std::unique_lock<std::mutex>& lock)
{
    _lookedAfter_s = base::steadySeconds();
    _sink->beat(_missed > 0);
    if (!_sink->present())
        lose(lock, _sink->error());
    else if (watchesAnswers())
        listen();
}

bool BoardDevice::watchesAnswers() const
{
    return _codec->answer() >= 0 && _sink->settle_s() > 0 && _answers != Answers::NEVER;
}

void BoardDevice::listen()
{
    const bool heard = _sink->hears(static_cast<std::uint8_t>(_codec->answer()));
    if (_resetDue) return; // while it starts, a board may send anything
    if (heard)
    {
        _answers = Answers::YES;
        _answerDue_s = 0;
        _missed = 0;
        becomeReady();
    }
    else if (_answerDue_s > 0 && base::steadySeconds() > _answerDue_s)
        missAnswer();
}

// The bytes seem to have gone to a bootloader, or the board has no power. A bootloader ends when it
// gets no bytes.
void BoardDevice::missAnswer()
{
    _answerDue_s = 0;
    ++_missed;
    if (_answers == Answers::UNKNOWN && _missed > 1)
    {
        _answers = Answers::NEVER;
        _missed = 0;
        deviceLog().warn(
            "{}: never answers, so nobody knows whether it plays what it is sent, or is "
            "silent when it should be",
            _name);
        becomeReady();
        return;
    }
    if (_closing && _missed > 1)
    {
        deviceLog().error("{}: hasn't answered to its silence: {}", _name, kPlaysOn);
        return;
    }
    const double still_s = _sink->held_s();
    const std::string why = fmt::format("answers no more, as if it had been reset; for {:.0f} s "
                                        "nothing is written, so that its bootloader ends, and then "
                                        "it is silenced: until then {}",
                                        still_s,
                                        kPlaysOn);
    if (_ready) deviceLog().error("{}: {}", _name, why);
    fail(why);
    _resetDue = true;
    _settled_s = base::steadySeconds() + still_s;
}

void BoardDevice::fail(const std::string& why)
{
    _ready = false;
    _silenceWanted = false;
    _silentLeft = 0;
    _fields.dropWaiting();
    _inTurn = {};
    _onItsWay.clear();
    _counters.countLoss(why);
}

void BoardDevice::becomeReady()
{
    if (_ready) return;
    _ready = true;
    std::fill(_playing.duty.begin(), _playing.duty.end(), std::uint8_t(0));
    _counters.change(
        [](DeviceReport& report)
        {
            report.state = DeviceState::READY;
            ++report.reconnects;
        });
    deviceLog().info("{}: back, and silenced until the next field", _name);
}

// Bytes in the operating system's buffer can't be overtaken, so the line must be free, unless the
// codec allows to cut off a field.
double BoardDevice::nextWrite_s() const
{
    if (_resetDue) return _settled_s;
    if (_silenceWanted && _codec->restarts()) return 0;
    if (_silenceWanted || (fieldIsDue() && !isInserted()) || _silentLeft > 0) return _lineFree_s;
    if (_inTurn.swaps && !_closing) return _lineFree_s - kLate_s;
    return _closing ? base::steadySeconds() + kClosing_s : _repeatAt_s; // no repeats while closing
}

// New fields of a sequence that the line times are written between its swaps, once the last ones
// are.
bool BoardDevice::fieldIsDue() const
{
    if (!_fields.waits()) return false;
    return !isInserted() || (_inTurn.swaps->isFresh() && base::steadySeconds() >= _nextLoad_s);
}

BoardDevice::Piece BoardDevice::nextField()
{
    Piece piece;
    piece.kind = Piece::FIELD;
    piece.epoch = _epoch;
    const FieldQueue::Field& field = _fields.takeOff(_sequence = nextAfter(_sequence));
    piece.sentAt_s = field.sentAt_s;
    piece.isInserted = isInserted();
    piece.inTurn = std::move(_waiting);
    _waiting = {};
    if (piece.isInserted)
    {
        const double now_s = base::steadySeconds();
        _inTurn.swaps->replace(std::move(*piece.inTurn.swaps), now_s);
        _inTurn.swaps->append(piece.field, std::max(now_s, _lineFree_s), now_s + kAhead_s);
        _nextLoad_s = now_s + kSwapsNew_s;
    }
    else if (piece.inTurn.swaps)
        piece.inTurn.swaps->appendStart(piece.field);
    else if (!piece.inTurn.stored.empty())
        piece.field = piece.inTurn.stored;
    else
        _codec->appendField(piece.field, field.signal);
    return piece;
}

BoardDevice::Piece BoardDevice::nextSwaps()
{
    Piece piece;
    piece.kind = Piece::SWAPS;
    piece.epoch = _epoch;
    const double now_s = base::steadySeconds();
    if (now_s >= _repeatAt_s)
    {
        _inTurn.swaps->refresh();
        _repeatAt_s = now_s + kSwapsRepeat_s;
    }
    _inTurn.swaps->append(_bytes, std::max(now_s, _lineFree_s), now_s + kAhead_s);
    return piece;
}

BoardDevice::Piece BoardDevice::nextPiece()
{
    Piece piece;
    piece.epoch = _epoch;
    _bytes.clear();
    if (_resetDue)
    {
        _inTurn = {};
        piece.kind = Piece::RESET;
        piece.field = _silentField;
        _bytes = _reset;
        _openingAt_s = base::steadySeconds();
        return piece;
    }
    if (_silenceWanted || (!_fields.waits() && _silentLeft > 0))
    {
        piece.kind = Piece::SILENCE;
        piece.field = _silentField;
        _inTurn = {};
    }
    else if (fieldIsDue())
        piece = nextField();
    else if (_inTurn.swaps)
        return nextSwaps();
    else
        piece.field = _current;
    const double now_s = base::steadySeconds();
    // A sequence brings its own opening; what a board has stored, the next field's opening undoes.
    const bool isStored = piece.isInserted || piece.inTurn.isSequence() ||
                          (piece.kind == Piece::REPEAT && !_inTurn.stored.empty());
    const bool isUndone = piece.kind == Piece::FIELD && !_inTurn.stored.empty();
    if (!isStored && (piece.kind != Piece::FIELD || isUndone || now_s - _openingAt_s >= kRepeat_s))
    {
        _codec->appendOpening(_bytes);
        _openingAt_s = now_s;
    }
    _bytes.insert(_bytes.end(), piece.field.begin(), piece.field.end());
    return piece;
}

void BoardDevice::writeNext(std::unique_lock<std::mutex>& lock)
{
    if (watchesAnswers()) // the line is free, so answers from here on are for this piece
    {
        listen();
        if (nextWrite_s() > base::steadySeconds()) return;
    }
    const bool overtakes = !_resetDue && _silenceWanted && _codec->restarts();
    Piece piece = nextPiece();
    if (overtakes) _onItsWay.clear(); // discarded is not sent
    lock.unlock();
    if (overtakes) _sink->discard();
    const bool written = _sink->write(_bytes);
    lock.lock();
    if (written)
    {
        finish(std::move(piece));
        return;
    }
    if (piece.kind == Piece::FIELD) _fields.loseOldest();
    lose(lock, _sink->error());
}

void BoardDevice::finish(Piece piece)
{
    const double now_s = base::steadySeconds();
    const double onLine_s = static_cast<double>(_bytes.size()) / _codec->bytesPerSecond();
    const bool newest = piece.epoch == _epoch;
    const bool isAhead = piece.kind == Piece::SWAPS || piece.isInserted;
    _written += _bytes.size();
    _lineFree_s = (isAhead ? std::max(now_s, _lineFree_s) : now_s) + onLine_s;
    if (piece.kind == Piece::SWAPS) return;
    if (!isAhead) _repeatAt_s = now_s + std::max(kRepeat_s, 2 * onLine_s);
    if (watchesAnswers() && _answerDue_s == 0) _answerDue_s = _lineFree_s + kAnswer_s;
    switch (piece.kind)
    {
    case Piece::RESET:
        _resetDue = false;
        if (newest) noteWritten(_silenceAsked_s);
        _silenceWanted = _silenceWanted && !newest;
        _silentLeft = 0;
        // A board that answers is ready once it has answered. When it is opened first, the state is
        // READY already, and fields may wait.
        if (_counters.report().state == DeviceState::LOST && !watchesAnswers()) becomeReady();
        break;
    case Piece::SILENCE:
        if (!newest) break;
        noteWritten(_silenceAsked_s);
        _silentLeft = _silenceWanted ? _codec->silentFields() - 1 : std::max(0, _silentLeft - 1);
        _silenceWanted = false;
        break;
    case Piece::FIELD:
    {
        _silentLeft = 0; // the board's buffers hold silence and this field
        noteWritten(piece.sentAt_s, piece.isInserted || piece.inTurn.isSequence());
        if (!piece.isInserted) _inTurn = std::move(piece.inTurn);
        if (_inTurn.swaps && !piece.isInserted) _inTurn.swaps->begin(_lineFree_s);
        auto played = _fields.settleUntil(_sequence, _sequence);
        if (newest && played) _playing = std::move(*played);
        _counters.change(
            [&](DeviceReport& report)
            {
                report.lastHandedOver_s = now_s;
                report.latency_s = now_s - piece.sentAt_s;
            });
        break;
    }
    case Piece::SWAPS:
    case Piece::REPEAT:
        break;
    }
    if (piece.kind != Piece::REPEAT) _current = std::move(piece.field);
}

// A sequence keeps the line busy, or takes it for longer than a field: it counts as sent.
void BoardDevice::noteWritten(double asked_s, bool isTimed)
{
    if (isTimed)
        _confirmed_s = std::max(_confirmed_s, asked_s);
    else
        _onItsWay.push_back({asked_s, _written});
}

// Silences the board that is given up: this program writes the reset, or, if it can't, the guard
// process does (bequeath()).
void BoardDevice::lose(std::unique_lock<std::mutex>& lock, std::string why)
{
    const bool settled = !_resetDue || base::steadySeconds() >= _settled_s;
    std::unique_ptr<ByteSink> sink = std::move(_sink);
    const bool first = _ready;
    fail(why);
    _resetDue = false;
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
    why += "; ";
    why += silenced ? kWasSilenced : kPlaysOn;
    if (silenced) std::fill(_playing.duty.begin(), _playing.duty.end(), std::uint8_t(0));
    _counters.change([&](DeviceReport& report) { report.message = why; });
    if (first) deviceLog().error("{}: {}", _name, why);
}

} // namespace midair::device
