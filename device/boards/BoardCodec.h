#pragma once

#include "device/drive/DriveSignal.h"

#include <array>
#include <complex>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace midair::device
{

/// Protocol of a kind of open board: converts a field to bytes and computes the board's output.
/// Pure functions without hardware.
///
/// The boards take a phase as a delay: a larger number is later. It is minus our phase, whose level
/// L means e^{+j 2 pi L/256}. A duty level L is a pulse of L/510 of the period, centred on the
/// phase.
class BoardCodec
{
public:
    virtual ~BoardCodec() = default;

    virtual const char* name() const = 0;
    /// Returns true if a board, or a chain of them, can have this number of transducers.
    virtual bool takes(int transducers) const = 0;
    virtual std::string takesText() const = 0; ///< for messages: "256 transducers"
    virtual int phaseLevels() const = 0;
    virtual std::vector<float> amplitudes() const = 0; ///< ascending from 0 to 1
    virtual double bytesPerSecond() const = 0;
    double fieldsPerSecond(int transducers) const; ///< capacity of the connection

    /// Appends the commands that prepare the board for fields from any state; may be empty. Written
    /// before the first field and repeated at intervals, because the board may have taken a damaged
    /// byte for another command. Harmless between any two fields.
    virtual void appendOpening(std::vector<std::uint8_t>& out) const = 0;
    /// Appends one field.
    virtual void appendField(std::vector<std::uint8_t>& out, const DriveSignal& signal) const = 0;
    /// Returns true if a new field may begin within a truncated one, which is then never played.
    virtual bool restarts() const = 0;

    /// Maximum number of signals of a sequence timed by the board, or by its line; 0: no sequences.
    virtual int sequenceFields() const { return 0; }
    /// DriveAbility::sequenceClock_Hz of such sequences.
    virtual double sequenceClock_Hz() const { return 0; }
    using Pieces = std::vector<std::vector<std::uint8_t>>;
    /// Returns \a sequence for a board that stores and times it, in pieces about as long as a
    /// field; empty if it can't. Silent fields may come instead of a later piece; anything else
    /// needs appendBreak() first. The next appendField() needs the opening before it.
    virtual Pieces piecesOf(const DriveSequence& /*sequence*/) const { return {}; }
    /// Appends the bytes that end a truncated sequence: the board holds the first field of it.
    virtual void appendBreak(std::vector<std::uint8_t>& /*out*/) const {}
    /// Two control bytes of a board with two buffers, whose fields end with \a exchange.
    struct Swap
    {
        std::uint8_t exchange; ///< brings the other buffer to the front
        std::uint8_t ignored;  ///< does nothing between fields
    };
    /// Null: the board has no such bytes. Otherwise it plays two fields in turn (BufferSwaps).
    virtual const Swap* swap() const { return nullptr; }

    /// Sets \a q to the board's output for \a signal, in its own phase and amplitude steps.
    virtual void played(const DriveSignal& signal, std::vector<std::complex<float>>& q) const = 0;

    /// Appends one field with all transducers off. A board with two buffers keeps the previous
    /// field in the other one.
    virtual void appendSilentField(std::vector<std::uint8_t>& out, int transducers) const;
    /// Number of consecutive silent fields that overwrite all of an older field in the board, even
    /// a truncated one.
    virtual int silentFields() const = 0;
    /// Appends the opening and silentFields() silent fields, so that a later swap of buffers can't
    /// bring an old field back.
    void appendSilence(std::vector<std::uint8_t>& out, int transducers) const;
    /// Byte that the board returns for every received field; negative: none.
    virtual int answer() const { return -1; }
    /// Appends the bytes that silence everything on the line, including boards without fields from
    /// this program, such as one stacked on ours.
    virtual void appendReset(std::vector<std::uint8_t>& out, int transducers) const
    {
        appendSilence(out, transducers);
    }
};

// Helpers of the codecs.

/// Returns round(-phase * steps / 256) in 0 .. steps-1: a phase level of 0 .. 255 as a delay in
/// steps of the period.
int delaySteps(int phase, int steps);

/// Returns the activation of a pulse of \a duty of the period, 0 .. 1/2, whose centre is \a
/// delay_turns periods late.
std::complex<float> pulseActivation(double delay_turns, double duty);

/// Plays two fields in turn on a board that exchanges two buffers at a byte (BoardCodec::swap()),
/// faster than its line carries fields: makes the bytes for any time span of the line.
///
/// Fills the time between swaps with bytes that the board ignores, so that the line's own rate
/// keeps the time, to one byte, however late this program wakes. A swap's time depends only on the
/// line's time, so unsent bytes shift nothing after them. On request the hidden buffer is rewritten
/// while no swap is due, or swaps pause for that long.
class BufferSwaps
{
public:
    /// \a sequence has at least one signal.
    BufferSwaps(const BoardCodec& codec, const DriveSequence& sequence);

    /// Number of different fields of the sequence on the board; 3 for more than two, which is
    /// unplayable. One field needs no swaps.
    int fields() const { return _count; }

    /// Appends the bytes that fill both buffers, with the first field in front. The sequence runs
    /// from \a begin_s on, when the last of them has left the line.
    void appendStart(std::vector<std::uint8_t>& out) const;
    void begin(double begin_s) { _begin_s = begin_s; }

    /// Appends the bytes for the line's time from \a from_s to \a until_s, or a field longer.
    void append(std::vector<std::uint8_t>& out, double from_s, double until_s);

    /// Requests that both buffers are rewritten, one after the other.
    void refresh() { _isDue = {true, true}; }
    /// Returns true when that is done.
    bool isFresh() const { return !_isDue[0] && !_isDue[1]; }
    /// Continues with the fields of \a next, in step if it has the same rate and number of signals.
    /// Rewrites those that differ.
    void replace(BufferSwaps next, double now_s);

private:
    /// Index of the buffer that should be in front.
    std::size_t wantedAt(double time_s) const;

    double _byte_s;
    std::uint8_t _swap;
    std::uint8_t _idle;
    double _rate_Hz;
    double _begin_s = 0;
    int _count = 0;
    std::vector<std::size_t> _order;                  ///< index of each signal's field
    std::array<std::vector<std::uint8_t>, 2> _fields; ///< their bytes, without the swap
    std::array<bool, 2> _isDue{};
    std::size_t _front = 0; ///< 0 for the first signal's field
};

} // namespace midair::device
