#pragma once

#include "haptics/surface/FeatureChains.h"
#include "haptics/surface/SampleBuilder.h"

#include <random>
#include <vector>

namespace midair::haptics
{

/// Points along the chains in equal steps of at least the edge spacing, \a shift (0 .. 1) of a step on from the chain's
/// start; with 0 from corner to corner.
void placeChains(SampleBuilder& builder, const std::vector<FeatureChain>& chains, double shift);

/// Closes what the equal steps leave: afterwards no spot of a feature edge is farther than 1.05 edge spacings from a point.
void fillEdges(SampleBuilder& builder);

/// Area-weighted random darts over the faces, about 40 area/spacing^2 of them; those farthest from the points
/// of \a earlier sets come first, if given.
void throwDarts(SampleBuilder& builder, std::mt19937_64& random, const PointGrid* earlier);

/// Closes what the darts leave: afterwards no spot of the surface is farther than 1.05 spacings from a point.
void fillFaces(SampleBuilder& builder);

} // namespace midair::haptics
