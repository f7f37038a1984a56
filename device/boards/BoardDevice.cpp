#include "device/boards/BoardDevice.h"

#include <algorithm>
#include <numeric>

#include <fmt/format.h>

namespace midair::device
{

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
    _sound.signal.phase.assign(transducers, 0);
    _sound.signal.duty.assign(transducers, 0);
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
    _ready = true; // while the board is starting, the newest field waits
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

// The loudest signal comes first: a modulation whose fields are replaced then goes on in the
// board's time, wherever in its period the host was.
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
        _board.codec->appendSequence(inTurn.stored, sequence);
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
    if (_sink == nullptr) return; // lost: it stays what lose() left
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

// While the board is starting, nothing that was sent has gone out. A line that hangs takes bytes
// for seconds, until the computer's buffer is full.
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

} // namespace midair::device
