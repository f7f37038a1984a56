#include "device/simulation/SimulatedBoard.h"

#include "device/boards/BoardKind.h"

#include <algorithm>

namespace midair::device
{

SimulatedBoard::SimulatedBoard(const std::string& scheme, int transducers) :
    _transducers(transducers),
    _codec(makeBoardCodec(scheme)),
    _board(makeVirtualBoard(scheme, transducers))
{
    _codec->appendReset(_bytes, transducers);
    give(0);
}

void SimulatedBoard::play(const DriveSignal& signal, double now_s)
{
    _inTurn.signals.clear();
    _bytes.clear();
    _codec->appendField(_bytes, signal);
    give(now_s);
}

bool SimulatedBoard::playSequence(const DriveSequence& sequence, double now_s)
{
    std::vector<std::uint8_t> stored;
    if (sequence.signals.size() > static_cast<std::size_t>(_codec->sequenceFields()) ||
        (_codec->swap() == nullptr && !_codec->appendSequence(stored, sequence)))
        return false;
    _inTurn = sequence;
    _inTurnSince_s = now_s;
    _inTurnStep = -1;
    advance(now_s);
    return true;
}

void SimulatedBoard::advance(double now_s)
{
    if (_inTurn.signals.empty()) return;
    constexpr std::int64_t kMostSteps = 200; // more than the history keeps of a modulation
    const auto step = static_cast<std::int64_t>((now_s - _inTurnSince_s) * _inTurn.rate_Hz);
    for (_inTurnStep = std::max(_inTurnStep, step - kMostSteps); _inTurnStep < step;)
    {
        const auto signal = static_cast<std::size_t>(++_inTurnStep) % _inTurn.signals.size();
        _bytes.clear();
        _codec->appendField(_bytes, _inTurn.signals[signal]);
        give(_inTurnSince_s + static_cast<double>(_inTurnStep) / _inTurn.rate_Hz);
    }
}

void SimulatedBoard::silence(double now_s)
{
    _inTurn.signals.clear();
    _bytes.clear();
    _codec->appendSilence(_bytes, _transducers);
    give(now_s);
}

void SimulatedBoard::give(double now_s)
{
    _board->receive(_bytes.data(), _bytes.size());
    Activations q = _board->playing();
    if (!_history.newest() || q != *_history.newest()) _history.note(now_s, std::move(q));
}

} // namespace midair::device
