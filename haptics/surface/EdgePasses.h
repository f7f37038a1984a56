#pragma once

#include "haptics/surface/FeatureChains.h"
#include "haptics/surface/SampleBuilder.h"

#include <vector>

namespace midair::haptics
{

/// Places points along the chains in equal steps of at least the edge spacing. \a shift (0 .. 1):
/// offset of the first point from the chain's start, in steps; 0: from corner to corner.
void placeChains(SampleBuilder& builder, const std::vector<FeatureChain>& chains, double shift);

/// Fills the gaps that placeChains() leaves: afterwards no place on a feature edge is farther
/// than 1.05 edge spacings from a point.
void fillEdges(SampleBuilder& builder);

} // namespace midair::haptics
