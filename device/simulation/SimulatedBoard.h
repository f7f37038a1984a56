#pragma once

#include "device/PlayedHistory.h"
#include "device/boards/BoardCodec.h"
#include "device/drive/DriveSequence.h"
#include "device/simulation/VirtualBoard.h"

#include <complex>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace midair::device
{

/// An open board that is simulated: what is sent goes as its codec's bytes to a VirtualBoard, and
/// what that has played is kept. Has no lock: the owner guards it. Times never decrease.
class SimulatedBoard
{
public:
    using Activations = std::vector<std::complex<float>>;

    /// \a scheme: one of boardKinds(). Resets the board at time 0.
    SimulatedBoard(const std::string& scheme, int transducers);

    const BoardCodec& codec() const { return *_codec; }
    void play(const DriveSignal& signal, double now_s);
    /// The board goes on with it by itself. What it stores, or exchanges at the pace of its line,
    /// is given to it field by field here. Returns false if this board can't, or not so long ones.
    bool playSequence(const DriveSequence& sequence, double now_s);
    /// Gives it the fields of its sequence that are due.
    void advance(double now_s);
    void silence(double now_s);

    Activations playing() const { return _board->playing(); }
    std::vector<std::pair<double, Activations>> playedSince(double from_s) const
    {
        return _history.since(from_s);
    }

private:
    void give(double now_s); ///< _bytes

    const int _transducers;
    const std::unique_ptr<BoardCodec> _codec;
    const std::unique_ptr<VirtualBoard> _board;
    std::vector<std::uint8_t> _bytes;
    DriveSequence _inTurn;     ///< that it plays by itself; no signals: none
    double _inTurnSince_s = 0; ///< when its first signal began
    std::int64_t _inTurnStep = 0;
    PlayedHistory<Activations> _history;
};

} // namespace midair::device
