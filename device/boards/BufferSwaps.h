#pragma once

#include "device/boards/BoardCodec.h"
#include "device/drive/DriveSequence.h"

#include <array>
#include <cstdint>
#include <vector>

namespace midair::device
{

/// Plays two fields in turn on a board that exchanges two buffers at a byte (BoardCodec::swap()),
/// faster than its line carries fields: makes the bytes of any span of the line's time.
///
/// Between the swaps stand bytes that the board ignores, so that the line's own pace keeps the
/// time, to one byte, however late this program wakes. Whether a swap is due depends on the line's
/// time alone, so that bytes which were never sent shift nothing that follows. The buffer that
/// doesn't sound is written anew on request, while no swap is due or, for as long as that takes,
/// none comes.
class BufferSwaps
{
public:
    /// \a sequence has one signal or more.
    BufferSwaps(const BoardCodec& codec, const DriveSequence& sequence);

    /// How many fields of the sequence differ on the board; 3 for more than two, which can't be
    /// played. One needs no swaps.
    int fields() const { return _count; }

    /// Appends the bytes that fill both buffers, and leave the first field in front. From \a
    /// begin_s on, when the last of them has left the line, the sequence runs.
    void appendStart(std::vector<std::uint8_t>& out) const;
    void begin(double begin_s) { _begin_s = begin_s; }

    /// Appends the bytes for the line's time from \a from_s until \a until_s, or a field longer.
    void append(std::vector<std::uint8_t>& out, double from_s, double until_s);

    /// Both buffers are to be written once more, one after the other.
    void refresh() { _isDue = {true, true}; }
    /// True once that has happened.
    bool isFresh() const { return !_isDue[0] && !_isDue[1]; }
    /// Goes on with the fields of \a next, in step if it has the same rate and as many signals.
    /// Those that differ are to be written.
    void replace(BufferSwaps next, double now_s);

private:
    /// The buffer that should be in front.
    std::size_t wantedAt(double time_s) const;

    double _byte_s;
    std::uint8_t _swap;
    std::uint8_t _idle;
    double _rate_Hz;
    double _begin_s = 0;
    int _count = 0;
    std::vector<std::size_t> _order;                  ///< which field each signal is
    std::array<std::vector<std::uint8_t>, 2> _fields; ///< their bytes, without the swap
    std::array<bool, 2> _isDue{};
    std::size_t _front = 0; ///< the first signal's field is number 0
};

} // namespace midair::device
