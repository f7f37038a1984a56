#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/points/ControlPoints.h"

#include <vector>

namespace midair::haptics
{

/// Share of what a focus of its own reaches, over the root of the number of points, that each of
/// many points is sure to get; below what solvers reach, so that it is exceeded by none of them
/// (tests/haptics/sequence/FocusShareTest.cpp).
constexpr double kSureShare = 0.3;

/// Lowers the targets of those points of \a points, by their indices \a small, that stand for
/// objects which are one focus each, to what one of their points would get if the objects had their
/// \a whole points: one focus has all of the sound. Where there are no others, targets in Pa take
/// the place of relative ones, and \a loudness counts up to 1.
void holdToShare(const std::vector<int>& small,
                 int whole,
                 double loudness,
                 const TransducerArray& array,
                 const Medium& medium,
                 ControlPoints& points);

} // namespace midair::haptics
