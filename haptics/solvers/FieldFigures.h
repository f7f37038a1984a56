#pragma once

#include "haptics/solvers/FieldProblem.h"

#include <algorithm>
#include <cmath>

/// Figures of a field as its problem holds it: y = |p|, a the targets.
namespace midair::haptics
{

/// rms of y_l/(s a_l) - 1.
inline float errorOf(const FieldProblem& field, float s)
{
    const auto error = field.y.array() / (s * field.a.array()) - 1.0f;
    return std::sqrt(error.square().mean());
}

/// s = (y.a)/(a.a).
inline float fittedLevel(const FieldProblem& field)
{
    return field.y.dot(field.a) / field.a.squaredNorm();
}

/// E = s |a| / mean_l(sum_i |G_li|).
inline float loudnessAt(const FieldProblem& field, float s)
{
    return s * field.a.norm() / static_cast<float>(field.meanRowSum());
}

/// The rms error that phases of the device's levels leave: off by up to pi/levels, rms pi/(sqrt 3 levels), spread over m
/// transducers (0.0071 sqrt(n/m)/E for 256 levels).
inline float roundingError(const FieldProblem& field)
{
    const int levels = field.drive().phaseLevels;
    if (levels == 0) return 0.0f;
    return 1.814f / static_cast<float>(std::max(levels, 2)) *
           std::sqrt(static_cast<float>(field.n()) / static_cast<float>(field.m())) /
           std::max(loudnessAt(field, fittedLevel(field)), 0.05f);
}

} // namespace midair::haptics
