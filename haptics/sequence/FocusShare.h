#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/points/ControlPoints.h"

#include <vector>

namespace midair::haptics
{

/// Share of a single focus's pressure, over the root of the number of points, that each of many
/// points gets at least; all solvers exceed it (tests/haptics/sequence/FocusShareTest.cpp).
constexpr double kSureShare = 0.3;

/// Lowers the targets of the points \a small (indices into \a points), each an object as small as
/// one focus, to what one of their points would get if the objects had their \a whole points,
/// because a single focus gets all of the sound. If there are no other points, targets in Pa
/// replace relative ones, and \a loudness counts up to 1.
void holdToShare(const std::vector<int>& small,
                 int whole,
                 double loudness,
                 const TransducerArray& array,
                 const Medium& medium,
                 ControlPoints& points);

} // namespace midair::haptics
