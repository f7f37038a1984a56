#pragma once

#include "haptics/surface/SampleBuilder.h"

#include <random>

namespace midair::haptics
{

/// Area-weighted random darts over the faces, about 40 area/spacing^2 of them; those farthest from
/// the points of \a earlier sets come first, if given.
void throwDarts(SampleBuilder& builder, std::mt19937_64& random, const PointGrid* earlier);

/// Closes what the darts leave: afterwards no spot of the surface is farther than 1.05 spacings
/// from a point.
void fillFaces(SampleBuilder& builder);

} // namespace midair::haptics
