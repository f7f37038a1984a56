#pragma once

#include "device/drive/DriveSignal.h"

#include <complex>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace midair::device
{

/// How one kind of open board takes a field: the bytes, and what it makes of them. Pure, no
/// hardware.
///
/// All know a phase as a delay: a larger number is later, so it is minus our phase, whose level L
/// means e^{+j 2 pi L/256}. A duty level L is a pulse of L/510 of the period, centred on the phase,
/// as everywhere.
class BoardCodec
{
public:
    virtual ~BoardCodec() = default;

    virtual const char* name() const = 0;
    virtual bool takes(int transducers) const = 0;
    virtual std::string takesText() const = 0; ///< for messages: "256 transducers"
    virtual int phaseLevels() const = 0;
    virtual std::vector<float> amplitudes() const = 0; ///< ascending from 0 to 1
    virtual double bytesPerSecond() const = 0;
    double fieldsPerSecond(int transducers) const; ///< that the line carries

    /// Appends what makes the board take fields, whatever it was told before; may be nothing. It
    /// goes before the first field, and again now and then, since a byte that arrives damaged may
    /// have told it something else. Harmless between any two fields.
    virtual void appendOpening(std::vector<std::uint8_t>& out) const = 0;
    /// Appends one field.
    virtual void appendField(std::vector<std::uint8_t>& out, const DriveSignal& signal) const = 0;
    /// Whether a new field may begin in the middle of one that was cut off, which then never
    /// sounds.
    virtual bool restarts() const = 0;

    /// What the board makes of \a signal: its own phase and amplitude steps.
    virtual void played(const DriveSignal& signal, std::vector<std::complex<float>>& q) const = 0;

    /// Appends one field with all off. Boards that exchange two buffers still hold the field before
    /// it, in the other one.
    virtual void appendSilentField(std::vector<std::uint8_t>& out, int transducers) const;
    /// How many silent fields in a row leave nothing of an older one in the board, also of one that
    /// was cut off.
    virtual int silentFields() const = 0;
    /// Appends the opening and that many silent fields: a swap that nobody asked for brings nothing
    /// back.
    void appendSilence(std::vector<std::uint8_t>& out, int transducers) const;
    /// The byte that comes back for every field when the board has taken it; negative: the board
    /// never says anything.
    virtual int answer() const { return -1; }
    /// Appends what silences whatever is on the line, also what this program has told nothing: a
    /// board that is stacked on ours.
    virtual void appendReset(std::vector<std::uint8_t>& out, int transducers) const
    {
        appendSilence(out, transducers);
    }
};

// What the codecs have in common.

/// round(-phase * steps / 256) in 0 .. steps-1: a phase level of 0 .. 255 as a delay in steps of
/// the period.
int delaySteps(int phase, int steps);

/// The activation of a pulse of \a duty of the period, 0 .. 1/2, whose centre comes \a delay_turns
/// periods late.
std::complex<float> pulseActivation(double delay_turns, double duty);

} // namespace midair::device
