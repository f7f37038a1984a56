#pragma once

#include "haptics/surface/FeatureChains.h"
#include "haptics/surface/SampleBuilder.h"

#include <vector>

namespace midair::haptics
{

/// Places points along the chains in equal steps of at least the edge spacing, from \a shift (0 ..
/// 1) of a step behind the chain's start; with 0 from corner to corner.
void placeChains(SampleBuilder& builder, const std::vector<FeatureChain>& chains, double shift);

/// Fills what the equal steps leave: afterwards no place on a feature edge is farther than 1.05
/// edge spacings from a point.
void fillEdges(SampleBuilder& builder);

} // namespace midair::haptics
