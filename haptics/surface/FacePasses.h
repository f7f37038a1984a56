#pragma once

#include "haptics/surface/SampleBuilder.h"

#include <random>

namespace midair::haptics
{

/// Tries about 40 area/spacing^2 random points on the faces, weighted by area. If points of \a
/// earlier sets are given, tries those farthest from them first.
void throwDarts(SampleBuilder& builder, std::mt19937_64& random, const PointGrid* earlier);

/// Fills the gaps that throwDarts() leaves: afterwards no place on the surface is farther than 1.05
/// spacings from a point.
void fillFaces(SampleBuilder& builder);

} // namespace midair::haptics
