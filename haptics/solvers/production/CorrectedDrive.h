#pragma once

#include "haptics/solvers/production/DriveAmplitudes.h"
#include "haptics/solvers/production/GaussNewtonStep.h"
#include "haptics/solvers/production/ShapedRounding.h"

namespace midair::haptics
{

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
