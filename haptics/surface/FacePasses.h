#pragma once

#include "haptics/surface/SampleBuilder.h"

#include <random>

namespace midair::haptics
{

/// Throws random darts over the faces, weighted by area, about 40 area/spacing^2 of them. Where \a
/// earlier sets are given, those farthest from their points come first.
void throwDarts(SampleBuilder& builder, std::mt19937_64& random, const PointGrid* earlier);

/// Fills what the darts leave: afterwards no place on the surface is farther than 1.05 spacings
/// from a point.
void fillFaces(SampleBuilder& builder);

} // namespace midair::haptics
