#pragma once

#include "haptics/solvers/FieldProblem.h"
#include "haptics/solvers/production/GaussNewtonStep.h"
#include "haptics/solvers/production/ShapedRounding.h"

namespace midair::haptics
{

/// The amplitudes of the transducers, on the device's levels (SOLVER.md, "Amplitudes"). Phase-only,
/// all play one amplitude, or an even mix of the two levels next to it; else |q_i| = min(1, g
/// |z_i|), which takes the least power for a field.
class DriveAmplitudes
{
public:
    /// What is asked for.
    struct Wish
    {
        bool phaseOnly = true;
        float loudness = 1.0f; ///< share of what the array can do, 0 .. 1
        float level_Pa =
            0.0f; ///< level s for targets in Pa, the largest target; 0: relative targets
    };

    void reserve(const FieldProblem& field)
    {
        _amplitudes.reserve(static_cast<std::size_t>(field.G.paddedTransducers()));
    }
    /// Chooses amplitudes for the phases field.q (|q_i| = 1), whose level is \a full, and scales
    /// field.q and y by them; field.z = G* c belongs to field.q.
    void choose(FieldProblem& field, const Wish& wish, float full);
    /// Changes all amplitudes by \a ratio, as far as they are playable. Returns false, with nothing
    /// changed, if that is less than half of leastChange().
    bool scale(const FieldProblem& field, float ratio);
    /// Returns the least relative change of the level that the device's amplitudes allow.
    float leastChange(const FieldProblem& field) const;
    /// Returns true if no larger amplitudes are playable.
    bool isFull() const { return _full || (_wish.phaseOnly && _gain >= 1.0f); }

    /// m amplitudes; null: all are 1.
    const float* data() const { return _full ? nullptr : _amplitudes.data(); }
    /// rms of the amplitudes, 0 .. 1.
    float rms(const FieldProblem& field) const;

private:
    void set(const FieldProblem& field);

    Wish _wish;
    float _gain = 1.0f; // phase-only: the mean amplitude; else g
    bool _full = true;  // all amplitudes are 1
    base::AlignedBuffer<float> _amplitudes;
};

/// The drive that corrections work on: continuous phases, the amplitudes, and the way from both to
/// what the device plays. field.q, p, y and u always belong to the last measurement.
class CorrectedDrive
{
public:
    /// Takes over field.q, |q_i| = 1.
    void begin(const FieldProblem& field);
    /// Measures the phases as they are, with their amplitudes.
    void measure(FieldProblem& field) { advance(field, nullptr, nullptr, nullptr); }
    /// Turns the phases by \a step and measures them.
    void turn(FieldProblem& field, const GaussNewtonStep& step)
    {
        advance(field, &step, nullptr, nullptr);
    }
    /// Rounds the phases to the device's levels, after turning them by \a step if that is not null,
    /// and measures what is played; the continuous phases stay.
    void play(FieldProblem& field,
              const QuietPoints& quiet,
              const GaussNewtonStep* step,
              const ShapedRounding::Effort& effort)
    {
        advance(field, step, &effort, &quiet);
    }

    /// The continuous phases, |.| = 1 (m).
    SplitVector& phases() { return _phases; }

    DriveAmplitudes amplitudes;

private:
    void advance(FieldProblem& field,
                 const GaussNewtonStep* step,
                 const ShapedRounding::Effort* effort,
                 const QuietPoints* quiet);
    void put(FieldProblem& field, int block, const ShapedRounding::Effort* effort);

    SplitVector _phases;
    ShapedRounding _shaping;
};

} // namespace midair::haptics
