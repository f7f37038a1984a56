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
    _name(name),
    _codec(std::move(codec)),
    _transducers(transducers),
    _open(std::move(open))
{
    if (!_codec->takes(transducers))
        throw DeviceError(fmt::format("device \"{}\": a {} has {}, but the array has {}",
                                      name,
                                      _codec->name(),
                                      _codec->takesText(),
                                      transducers));
    _codec->appendReset(_reset, transducers);
    _codec->appendSilentField(_silentField, transducers);
    _playing.phase.assign(transducers, 0);
    _playing.duty.assign(transducers, 0);
    adopt(_open(_reset));
    if (_settled_s <= base::steadySeconds())
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
        std::lock_guard<std::mutex> lock(_mutex);
        silenceLocked();
        _closing = true;
    }
    _wake.notify_all();
    _thread.join();
}

bool BoardDevice::send(const DriveSignal& signal)
{
    std::lock_guard<std::mutex> lock(_mutex);
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
    const auto most = static_cast<std::size_t>(_codec->sequenceFields());
    const bool isRight = sequence.fits(_transducers) && sequence.signals.size() <= most;
    if (isRight && _codec->swap() != nullptr)
        inTurn.swaps = std::make_unique<BufferSwaps>(*_codec, sequence);
    else if (isRight)
        _codec->appendSequence(inTurn.stored, sequence);
    const int fields = inTurn.swaps ? inTurn.swaps->fields() : 0;
    if (fields == 1 || fields > 2) inTurn.swaps.reset();
    std::lock_guard<std::mutex> lock(_mutex);
    if (!inTurn.isSequence() && fields != 1)
    {
        _fields.refuse();
        return false;
    }
    return put(sequence.signals.front(), std::move(inTurn));
}

bool BoardDevice::put(const DriveSignal& signal, InTurn inTurn)
{
    if (!signal.fits(_transducers) || !_ready || _closing)
    {
        _fields.refuse();
        return false;
    }
    _fields.put(signal, base::steadySeconds(), nullptr);
    _waiting = std::move(inTurn);
    _wake.notify_all();
    return true;
}

void BoardDevice::silenceLocked()
{
    _fields.dropWaiting();
    if (_sink == nullptr) return; // lost: _playing stays what lose() left
    std::fill(_playing.duty.begin(), _playing.duty.end(), std::uint8_t(0));
    ++_epoch;
    _silenceWanted = true;
    _silenceAsked_s = base::steadySeconds();
    _wake.notify_all();
}

void BoardDevice::silence()
{
    std::lock_guard<std::mutex> lock(_mutex);
    silenceLocked();
}

// While the board is starting, nothing that was sent has gone out. A line that hangs takes bytes
// for seconds, until the computer's buffer is full.
double BoardDevice::confirmed_s() const
{
    std::lock_guard<std::mutex> lock(_mutex);
    if (_resetDue) return base::steadySeconds();
    if (_onItsWay.empty() || _sink == nullptr) return _confirmed_s;
    const std::uint64_t gone = _written - std::min<std::uint64_t>(_written, _sink->unsent());
    for (; !_onItsWay.empty() && _onItsWay.front().end <= gone; _onItsWay.pop_front())
        _confirmed_s = std::max(_confirmed_s, _onItsWay.front().asked_s);
    return _confirmed_s;
}

DeviceReport BoardDevice::report() const
{
    std::lock_guard<std::mutex> lock(_mutex);
    DeviceReport report = _counters.report();
    _fields.addTo(report);
    return report;
}

std::string BoardDevice::status() const
{
    const DeviceReport now = report();
    std::string text = _name + ": ";
    bool answers = false;
    {
        std::lock_guard<std::mutex> lock(_mutex);
        answers = _answers == Answers::YES;
        if (_sink == nullptr)
            text += "not there; ";
        else if (_resetDue)
            text += fmt::format("starting, is silenced in {:.0f} ms; ",
                                1000 * std::max(0.0, _settled_s - base::steadySeconds()));
    }
    return text + countersText(now) + (answers ? "" : " (the board does not answer)");
}

std::vector<std::complex<float>> BoardDevice::played() const
{
    std::vector<std::complex<float>> q;
    std::lock_guard<std::mutex> lock(_mutex);
    _codec->played(_playing, q);
    return q;
}

std::vector<std::complex<float>> BoardDevice::wouldPlay(const DriveSignal& signal) const
{
    std::vector<std::complex<float>> q;
    _codec->played(signal, q);
    return q;
}

} // namespace midair::device
