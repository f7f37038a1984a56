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

/// The protocol of one kind of open board: a field's bytes, and what the board plays of them. Pure
/// functions without hardware.
///
/// The boards take a phase as a delay: a larger number is later. So it is minus our phase, whose
/// level L means e^{+j 2 pi L/256}. A duty level L is a pulse of L/510 of the period, centred on
/// the phase.
class BoardCodec
{
public:
    virtual ~BoardCodec() = default;

    virtual const char* name() const = 0;
    /// Returns true if a board, or a chain of them, may have this number of transducers.
    virtual bool takes(int transducers) const = 0;
    virtual std::string takesText() const = 0; ///< for messages: "256 transducers"
    virtual int phaseLevels() const = 0;
    virtual std::vector<float> amplitudes() const = 0; ///< ascending from 0 to 1
    virtual double bytesPerSecond() const = 0;
    double fieldsPerSecond(int transducers) const; ///< the most that the connection carries

    /// Appends the commands that make the board take fields, whatever it was sent before; may be
    /// nothing. Written before the first field, and repeated at intervals, since the board may have
    /// taken a damaged byte for another command. Harmless between any two fields.
    virtual void appendOpening(std::vector<std::uint8_t>& out) const = 0;
    /// Appends one field.
    virtual void appendField(std::vector<std::uint8_t>& out, const DriveSignal& signal) const = 0;
    /// Returns true if a new field may begin in the middle of one that was cut off, which then is
    /// never played.
    virtual bool restarts() const = 0;

    /// The most signals of a sequence that the board times by itself, or by the pace of its line;
    /// 0: it takes none.
    virtual int sequenceFields() const { return 0; }
    /// DriveAbility::sequenceClock_Hz of such sequences.
    virtual double sequenceClock_Hz() const { return 0; }
    /// Appends \a sequence for a board that stores it and times it by itself. Returns false, and
    /// appends nothing, if it can't. appendField() after it needs the opening before it.
    virtual bool appendSequence(std::vector<std::uint8_t>& /*out*/,
                                const DriveSequence& /*sequence*/) const
    {
        return false;
    }
    /// Two bytes of a board with two buffers, the end of whose fields is \a exchange.
    struct Swap
    {
        std::uint8_t exchange; ///< brings the other buffer to the front
        std::uint8_t ignored;  ///< does nothing between fields
    };
    /// Null: the board has no such bytes. Else it plays two fields in turn (BufferSwaps).
    virtual const Swap* swap() const { return nullptr; }

    /// Sets \a q to what the board plays of \a signal, in its own phase and amplitude steps.
    virtual void played(const DriveSignal& signal, std::vector<std::complex<float>>& q) const = 0;

    /// Appends one field with all transducers off. A board with two buffers still has the field
    /// before in the other one.
    virtual void appendSilentField(std::vector<std::uint8_t>& out, int transducers) const;
    /// The number of silent fields in a row that overwrite everything of an older field in the
    /// board, even one that was cut off.
    virtual int silentFields() const = 0;
    /// Appends the opening and silentFields() silent fields, so that a later swap of buffers brings
    /// no old field back.
    void appendSilence(std::vector<std::uint8_t>& out, int transducers) const;
    /// The byte that the board sends back for every field that it has taken; negative: it sends
    /// nothing.
    virtual int answer() const { return -1; }
    /// Appends the bytes that silence everything on the line, including boards that this program
    /// sends no fields to, such as one stacked on ours.
    virtual void appendReset(std::vector<std::uint8_t>& out, int transducers) const
    {
        appendSilence(out, transducers);
    }
};

// Helpers of the codecs.

/// round(-phase * steps / 256) in 0 .. steps-1: a phase level of 0 .. 255 as a delay in steps of
/// the period.
int delaySteps(int phase, int steps);

/// The activation of a pulse of \a duty of the period, 0 .. 1/2, whose centre comes \a delay_turns
/// periods late.
std::complex<float> pulseActivation(double delay_turns, double duty);

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
