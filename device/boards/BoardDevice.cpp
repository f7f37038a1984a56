#include "device/boards/BoardDevice.h"

#include "device/DeviceLog.h"
#include "device/SequenceNumber.h"

#include <algorithm>
#include <numeric>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace midair::device
{

namespace
{

constexpr double kReconnect_s = 0.25;
constexpr double kRepeat_s = 0.2; ///< of the output; every other frame stays free for new fields
constexpr double kLook_s = 0.05;  ///< interval of lookAfterLine()
/// For a sequence timed by the line, the line is kept busy this far ahead, which a silence must
/// overtake; this thread may wake kLate_s late.
constexpr double kAhead_s = 0.03;
constexpr double kLate_s = 0.02;
constexpr double kSwapsRepeat_s = 0.5; ///< its buffers are rewritten; each time it pauses
constexpr double kSwapsNew_s = 0.1;    ///< minimum interval for new fields

constexpr double kClosing_s = 0.005; ///< likewise while closing
constexpr double kAnswer_s = 1;      ///< maximum answer time of a board, five repeats

constexpr const char* kPlaysOn =
    "the board has no watchdog and may still play its last field: cut its power";
constexpr const char* kWasSilenced = "silence was written to the board again, but the board "
                                     "doesn't confirm it: if it still plays, cut its power";

} // namespace

BoardDevice::BoardDevice(const std::string& name,
                         std::unique_ptr<BoardCodec> codec,
                         int transducers,
                         Open open) :
    _board{name, std::move(codec), transducers, std::move(open), {}, {}}
{
    if (!_board.codec->takes(transducers))
        throw DeviceError(fmt::format("device \"{}\": a {} has {}, but the array has {}",
                                      name,
                                      _board.codec->name(),
                                      _board.codec->takesText(),
                                      transducers));
    _board.codec->appendReset(_board.reset, transducers);
    _board.codec->appendSilentField(_board.silentField, transducers);
    _sound.signal = silentSignal(transducers);
    adopt(_board.open(_board.reset));
    if (_silencing.settled_s <= base::steadySeconds())
    {
        Piece first = nextPiece();
        if (!_sink->write(_bytes))
        {
            const std::string why = _sink->error();
            _sink->bequeath();
            throw DeviceError("device \"" + name + "\": " + why);
        }
        finish(std::move(first));
    }
    _ready = true; // the newest field waits while the board is starting
    _thread = std::thread([this] { run(); });
}

BoardDevice::~BoardDevice()
{
    {
        const base::Lock lock(_mutex);
        silenceLocked();
        _closing = true;
    }
    _wake.notifyAll();
    _thread.join();
}

bool BoardDevice::send(const DriveSignal& signal)
{
    const base::Lock lock(_mutex);
    return put(signal, {});
}

// The loudest signal comes first: if the fields of a modulation are replaced, it then continues in
// the board's time, whatever the host's position in the period.
bool BoardDevice::sendSequence(const DriveSequence& given)
{
    InTurn inTurn;
    DriveSequence sequence = given;
    const auto drive = [](const DriveSignal& signal)
    { return std::accumulate(signal.duty.begin(), signal.duty.end(), 0); };
    const auto loudest = std::max_element(sequence.signals.begin(),
                                          sequence.signals.end(),
                                          [&](const DriveSignal& a, const DriveSignal& b)
                                          { return drive(a) < drive(b); });
    std::rotate(sequence.signals.begin(), loudest, sequence.signals.end());
    const auto most = static_cast<std::size_t>(_board.codec->sequenceFields());
    const bool isRight = sequence.fits(_board.transducers) && sequence.signals.size() <= most;
    if (isRight && _board.codec->swap() != nullptr)
        inTurn.swaps = std::make_unique<BufferSwaps>(*_board.codec, sequence);
    else if (isRight)
        inTurn.stored = _board.codec->piecesOf(sequence);
    const int fields = inTurn.swaps ? inTurn.swaps->fields() : 0;
    if (fields == 1 || fields > 2) inTurn.swaps.reset();
    const base::Lock lock(_mutex);
    if (!inTurn.isSequence() && fields != 1)
    {
        _fields.queue.refuse();
        return false;
    }
    return put(sequence.signals.front(), std::move(inTurn));
}

bool BoardDevice::put(const DriveSignal& signal, InTurn inTurn)
{
    if (!signal.fits(_board.transducers) || !_ready || _closing)
    {
        _fields.queue.refuse();
        return false;
    }
    _fields.queue.put(signal, base::steadySeconds(), nullptr);
    _fields.waiting = std::move(inTurn);
    _wake.notifyAll();
    return true;
}

void BoardDevice::silenceLocked()
{
    _fields.queue.dropWaiting();
    if (_sink == nullptr) return; // lost: lose() has set the state
    _sound.silence();
    ++_silencing.epoch;
    _silencing.isWanted = true;
    _silencing.asked_s = base::steadySeconds();
    _wake.notifyAll();
}

void BoardDevice::silence()
{
    const base::Lock lock(_mutex);
    silenceLocked();
}

// While the board is starting, nothing has been sent yet. A hanging line accepts bytes for seconds,
// until the computer's buffer is full.
double BoardDevice::confirmed_s() const
{
    const base::Lock lock(_mutex);
    if (_silencing.isResetDue) return base::steadySeconds();
    if (_line.isAnyOnItsWay() && _sink != nullptr) _line.noteUnsent(_sink->unsent());
    return _line.confirmed_s();
}

DeviceReport BoardDevice::report() const
{
    const base::Lock lock(_mutex);
    DeviceReport report = _counters.report();
    _fields.queue.addTo(report);
    return report;
}

std::string BoardDevice::status() const
{
    const DeviceReport now = report();
    std::string text = _board.name + ": ";
    bool answers = false;
    {
        const base::Lock lock(_mutex);
        answers = _answers.known == Answers::YES;
        if (_sink == nullptr)
            text += "not there; ";
        else if (_silencing.isResetDue)
            text += fmt::format("starting, is silenced in {:.0f} ms; ",
                                1000 * std::max(0.0, _silencing.settled_s - base::steadySeconds()));
    }
    return text + countersText(now) + (answers ? "" : " (the board does not answer)");
}

std::vector<std::complex<float>> BoardDevice::played() const
{
    std::vector<std::complex<float>> q;
    const base::Lock lock(_mutex);
    _board.codec->played(_sound.signal, q);
    return q;
}

std::vector<std::complex<float>> BoardDevice::wouldPlay(const DriveSignal& signal) const
{
    std::vector<std::complex<float>> q;
    _board.codec->played(signal, q);
    return q;
}

void BoardDevice::run()
{
    base::Lock lock(_mutex);
    while (!_closing || !quiet())
    {
        const double now_s = base::steadySeconds();
        const double due_s = _sink != nullptr ? nextWrite_s() : 0;
        if (_sink == nullptr)
            reconnect(lock);
        else if (now_s - _rounds.lookedAfter_s >= (_closing ? kClosing_s : kLook_s))
            lookAfterLine();
        else if (due_s <= now_s)
            writeNext();
        else
            while (nextWrite_s() >= due_s &&
                   _wake.waitUntil_s(lock, std::min(due_s, now_s + kLook_s)))
            {
            }
    }
}

bool BoardDevice::quiet() const
{
    return _sink == nullptr ||
           (!_silencing.isResetDue && !_silencing.isWanted && _silencing.fieldsLeft == 0 &&
            base::steadySeconds() >= _line.free_s() && _answers.due_s == 0);
}

void BoardDevice::reconnect(base::Lock& lock)
{
    const double until_s = base::steadySeconds() + kReconnect_s;
    while (!_closing && _wake.waitUntil_s(lock, until_s))
    {
    }
    if (_closing) return;
    std::unique_ptr<ByteSink> sink;
    try
    {
        const base::Unlocked unlocked(_mutex);
        sink = _board.open(_board.reset);
    }
    catch (const DeviceError&)
    {
        // the reason was logged when it was lost
    }
    if (sink != nullptr) adopt(std::move(sink));
}

void BoardDevice::adopt(std::unique_ptr<ByteSink> sink)
{
    _silencing.settled_s = sink->settled_s();
    _sink = std::move(sink);
    _silencing.isResetDue = true;
    _rounds.lookedAfter_s = 0;
    _answers.due_s = 0;
    _answers.missed = 0;
}

void BoardDevice::lookAfterLine()
{
    _rounds.lookedAfter_s = base::steadySeconds();
    _sink->beat(_answers.missed > 0);
    if (!_sink->present())
        lose(_sink->error());
    else if (watchesAnswers())
        listen();
}

bool BoardDevice::watchesAnswers() const
{
    return _board.codec->answer() >= 0 && _sink->settle_s() > 0 && _answers.known != Answers::NEVER;
}

void BoardDevice::listen()
{
    const bool heard = _sink->hears(static_cast<std::uint8_t>(_board.codec->answer()));
    if (_silencing.isResetDue) return; // a starting board may send anything
    if (heard)
    {
        _answers.known = Answers::YES;
        _answers.due_s = 0;
        _answers.missed = 0;
        becomeReady();
    }
    else if (_answers.due_s > 0 && base::steadySeconds() > _answers.due_s)
        missAnswer();
}

// The bytes apparently reached a bootloader, or the board has no power. A bootloader ends when it
// gets no bytes.
void BoardDevice::missAnswer()
{
    _answers.due_s = 0;
    ++_answers.missed;
    if (_answers.known == Answers::UNKNOWN && _answers.missed > 1)
    {
        _answers.known = Answers::NEVER;
        _answers.missed = 0;
        deviceLog().warn("{}: never answers, so it may not play its fields, or may not fall silent",
                         _board.name);
        becomeReady();
        return;
    }
    if (_closing && _answers.missed > 1)
    {
        deviceLog().error("{}: hasn't confirmed its silence: {}", _board.name, kPlaysOn);
        return;
    }
    const double still_s = _sink->held_s();
    const std::string why = fmt::format("no longer answers, as after a reset; it is silenced in "
                                        "{:.0f} s, when its bootloader has ended: until then {}",
                                        still_s,
                                        kPlaysOn);
    if (_ready) deviceLog().error("{}: {}", _board.name, why);
    fail(why);
    _silencing.isResetDue = true;
    _silencing.settled_s = base::steadySeconds() + still_s;
}

void BoardDevice::fail(const std::string& why)
{
    _ready = false;
    _silencing.isWanted = false;
    _silencing.fieldsLeft = 0;
    _fields.queue.dropWaiting();
    while (_fields.queue.pending() > 0)
        _fields.queue.loseOldest();
    _sound.inTurn = {};
    _line.forget();
    _counters.countLoss(why);
}

void BoardDevice::becomeReady()
{
    if (_ready) return;
    _ready = true;
    _sound.silence();
    _counters.countReturn();
    deviceLog().info("{}: back, and silenced until the next field", _board.name);
}

// Bytes in the operating system's buffer can't be overtaken, so the line must be free, unless the
// codec can restart within a field.
double BoardDevice::nextWrite_s() const
{
    if (_silencing.isResetDue) return _silencing.settled_s;
    if (_silencing.isWanted && _board.codec->restarts()) return 0;
    if (_silencing.isWanted || (fieldIsDue() && !isInserted()) || _silencing.fieldsLeft > 0 ||
        _sound.inTurn.isBeingWritten())
        return _line.free_s();
    if (_sound.inTurn.swaps && !_closing) return _line.free_s() - kLate_s;
    return _closing ? base::steadySeconds() + kClosing_s
                    : _rounds.repeat_s; // no repeats while closing
}

// New fields of a sequence timed by the line are written between its swaps, when the previous ones
// are written.
bool BoardDevice::fieldIsDue() const
{
    if (!_fields.queue.waits()) return false;
    return !isInserted() ||
           (_sound.inTurn.swaps->isFresh() && base::steadySeconds() >= _sound.nextLoad_s);
}

BoardDevice::Piece BoardDevice::nextField()
{
    Piece piece;
    piece.kind = Piece::FIELD;
    piece.epoch = _silencing.epoch;
    if (_sound.inTurn.isBeingWritten()) _board.codec->appendBreak(_bytes);
    _fields.queue.dropFlying();
    const FieldQueue::Field& field =
        _fields.queue.takeOff(_fields.sequence = nextAfter(_fields.sequence));
    piece.sentAt_s = field.sentAt_s;
    piece.isInserted = isInserted();
    piece.inTurn = std::move(_fields.waiting);
    _fields.waiting = {};
    if (piece.isInserted)
    {
        const double now_s = base::steadySeconds();
        _sound.inTurn.swaps->replace(std::move(*piece.inTurn.swaps), now_s);
        _sound.inTurn.swaps->append(piece.field, std::max(now_s, _line.free_s()), now_s + kAhead_s);
        _sound.nextLoad_s = now_s + kSwapsNew_s;
    }
    else if (piece.inTurn.swaps)
        piece.inTurn.swaps->appendStart(piece.field);
    else if (!piece.inTurn.stored.empty())
    {
        piece.inTurn.sentAt_s = piece.sentAt_s;
        piece.field = piece.inTurn.stored[piece.inTurn.written++];
    }
    else
        _board.codec->appendField(piece.field, field.signal);
    return piece;
}

BoardDevice::Piece BoardDevice::nextUpload()
{
    Piece piece;
    piece.kind = Piece::UPLOAD;
    piece.epoch = _silencing.epoch;
    if (!_sound.inTurn.isBeingWritten()) _sound.inTurn.written = 0; // a repeat
    _bytes = _sound.inTurn.stored[_sound.inTurn.written++];
    return piece;
}

BoardDevice::Piece BoardDevice::nextSwaps()
{
    Piece piece;
    piece.kind = Piece::SWAPS;
    piece.epoch = _silencing.epoch;
    const double now_s = base::steadySeconds();
    if (now_s >= _rounds.repeat_s)
    {
        _sound.inTurn.swaps->refresh();
        _rounds.repeat_s = now_s + kSwapsRepeat_s;
    }
    _sound.inTurn.swaps->append(_bytes, std::max(now_s, _line.free_s()), now_s + kAhead_s);
    return piece;
}

BoardDevice::Piece BoardDevice::nextPiece()
{
    Piece piece;
    piece.epoch = _silencing.epoch;
    _bytes.clear();
    if (_silencing.isResetDue)
    {
        _sound.inTurn = {};
        piece.kind = Piece::RESET;
        piece.field = _board.silentField;
        _bytes = _board.reset;
        _rounds.openedLine_s = base::steadySeconds();
        return piece;
    }
    if (_silencing.isWanted || (!_fields.queue.waits() && _silencing.fieldsLeft > 0))
    {
        piece.kind = Piece::SILENCE;
        piece.field = _board.silentField;
        _fields.queue.dropFlying();
        _sound.inTurn = {};
    }
    else if (fieldIsDue())
        piece = nextField();
    else if (_sound.inTurn.swaps)
        return nextSwaps();
    else if (!_sound.inTurn.stored.empty())
        return nextUpload();
    else
        piece.field = _sound.bytes;
    const double now_s = base::steadySeconds();
    // A sequence contains its own opening; the next field's opening ends a stored sequence.
    const bool isStored = piece.isInserted || piece.inTurn.isSequence();
    const bool isUndone = piece.kind == Piece::FIELD && !_sound.inTurn.stored.empty();
    if (!isStored &&
        (piece.kind != Piece::FIELD || isUndone || now_s - _rounds.openedLine_s >= kRepeat_s))
    {
        _board.codec->appendOpening(_bytes);
        _rounds.openedLine_s = now_s;
    }
    _bytes.insert(_bytes.end(), piece.field.begin(), piece.field.end());
    return piece;
}

void BoardDevice::writeNext()
{
    if (watchesAnswers()) // the line is free, so later answers are for this piece
    {
        listen();
        if (nextWrite_s() > base::steadySeconds()) return;
    }
    const bool overtakes =
        !_silencing.isResetDue && _silencing.isWanted && _board.codec->restarts();
    Piece piece = nextPiece();
    if (overtakes) _line.forget(); // discarded bytes are not sent
    ByteSink& sink = *_sink;
    bool written = false;
    {
        const base::Unlocked unlocked(_mutex);
        if (overtakes) sink.discard();
        written = sink.write(_bytes);
    }
    if (written)
    {
        finish(std::move(piece));
        return;
    }
    lose(_sink->error());
}

void BoardDevice::finish(Piece piece)
{
    const double now_s = base::steadySeconds();
    const double onLine_s = static_cast<double>(_bytes.size()) / _board.codec->bytesPerSecond();
    const bool newest = piece.epoch == _silencing.epoch;
    const bool isAhead = piece.kind == Piece::SWAPS || piece.isInserted;
    _line.noteBytes(_bytes.size(), now_s, onLine_s, isAhead);
    if (piece.kind == Piece::SWAPS) return;
    if (piece.kind == Piece::UPLOAD) return noteUpload(now_s);
    if (!isAhead) _rounds.repeat_s = now_s + std::max(kRepeat_s, 2 * onLine_s);
    if (watchesAnswers() && _answers.due_s == 0 && !piece.inTurn.isBeingWritten())
        _answers.due_s = _line.free_s() + kAnswer_s;
    switch (piece.kind)
    {
    case Piece::RESET:
        _silencing.isResetDue = false;
        if (newest) _line.noteAsked(_silencing.asked_s);
        _silencing.isWanted = _silencing.isWanted && !newest;
        _silencing.fieldsLeft = 0;
        // A board that answers is ready after its answer. At the first opening the state is already
        // READY, and fields may wait.
        if (_counters.report().state == DeviceState::LOST && !watchesAnswers()) becomeReady();
        break;
    case Piece::SILENCE:
        if (!newest) break;
        _line.noteAsked(_silencing.asked_s);
        _silencing.fieldsLeft = _silencing.isWanted ? _board.codec->silentFields() - 1
                                                    : std::max(0, _silencing.fieldsLeft - 1);
        _silencing.isWanted = false;
        break;
    case Piece::FIELD:
    {
        _silencing.fieldsLeft = 0; // the board's buffers hold silence and this field
        if (piece.isInserted || piece.inTurn.isSequence())
            _line.noteSent(piece.sentAt_s);
        else
            _line.noteAsked(piece.sentAt_s);
        if (!piece.isInserted) _sound.inTurn = std::move(piece.inTurn);
        if (_sound.inTurn.swaps && !piece.isInserted) _sound.inTurn.swaps->begin(_line.free_s());
        if (_sound.inTurn.isBeingWritten()) break; // it is played with its last piece
        auto played = _fields.queue.settleUntil(_fields.sequence, _fields.sequence);
        if (newest && played) _sound.signal = std::move(*played);
        _counters.noteHandedOver(now_s, piece.sentAt_s);
        break;
    }
    case Piece::UPLOAD:
    case Piece::SWAPS:
    case Piece::REPEAT:
        break;
    }
    if (piece.kind != Piece::REPEAT) _sound.bytes = std::move(piece.field);
}

// With its last piece the board plays the sequence. Repeats take half of the line at most.
void BoardDevice::noteUpload(double now_s)
{
    const InTurn& inTurn = _sound.inTurn;
    if (inTurn.isBeingWritten()) return;
    if (watchesAnswers() && _answers.due_s == 0) _answers.due_s = _line.free_s() + kAnswer_s;
    std::size_t bytes = 0;
    for (const auto& piece : inTurn.stored)
        bytes += piece.size();
    const double onLine_s = static_cast<double>(bytes) / _board.codec->bytesPerSecond();
    _rounds.repeat_s = now_s + std::max(kRepeat_s, onLine_s);
    auto played = _fields.queue.settleUntil(_fields.sequence, _fields.sequence);
    if (!played) return; // a repeat
    _sound.signal = std::move(*played);
    _counters.noteHandedOver(now_s, inTurn.sentAt_s);
}

// Silences a board that is given up: this program writes the reset, or, if it can't, the guard
// process does (bequeath()).
void BoardDevice::lose(std::string why)
{
    const bool settled = !_silencing.isResetDue || base::steadySeconds() >= _silencing.settled_s;
    std::unique_ptr<ByteSink> sink = std::move(_sink);
    const bool first = _ready;
    fail(why);
    _silencing.isResetDue = false;
    bool silenced = false;
    {
        const base::Unlocked unlocked(_mutex);
        if (settled && sink->present())
        {
            sink->discard();
            silenced = sink->write(_board.reset);
        }
        silenced = silenced || sink->bequeath();
        sink.reset();
    }
    why += "; ";
    why += silenced ? kWasSilenced : kPlaysOn;
    if (silenced) _sound.silence();
    _counters.change([&](DeviceReport& report) { report.message = why; });
    if (first) deviceLog().error("{}: {}", _board.name, why);
}

} // namespace midair::device
