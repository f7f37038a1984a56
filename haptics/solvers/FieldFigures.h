#pragma once

#include "haptics/points/FittedLevel.h"
#include "haptics/solvers/FieldProblem.h"

#include <algorithm>
#include <cmath>

/// Figures of the field in a FieldProblem: y = |p| in Pa, a the targets.
namespace midair::haptics
{

/// Returns the rms of y_l/(s a_l) - 1.
inline float errorOf(const FieldProblem& field, float s)
{
    return relativeRms(field.y, field.a, s);
}

/// Returns s = (y.a)/(a.a), Pa at a_l = 1.
inline float fittedLevel(const FieldProblem& field)
{
    return fittedLevel(field.y, field.a);
}

/// Returns the loudness E = s |a| / mean_l(sum_i |G_li|).
inline float loudnessAt(const FieldProblem& field, float s)
{
    return loudnessOf(s, field.a.norm(), static_cast<float>(field.meanRowSum()));
}

/// Returns an estimate of the rms error due to rounding to the device's phase levels
/// (haptics/SOLVER.md, "Rounding"); 0 for continuous phases. \a amplitude: rms |q_i|.
inline float roundingError(const FieldProblem& field, float amplitude)
{
    constexpr float kOneLevel = 1.814f; // pi/sqrt(3): rms of a rounded phase times the levels, rad
    // Quieter fields count as this loud, so that the estimate stays finite.
    constexpr float kLeastLoudness = 0.05f;
    const int levels = field.drive().phaseLevels;
    if (levels == 0) return 0.0f;
    return kOneLevel / static_cast<float>(std::max(levels, 2)) *
           std::sqrt(static_cast<float>(field.n()) / static_cast<float>(field.m())) /
           std::max(loudnessAt(field, fittedLevel(field)) / amplitude, kLeastLoudness);
}

} // namespace midair::haptics
