#pragma once

#include "haptics/surface/FeatureChains.h"
#include "haptics/surface/SampleBuilder.h"

#include <random>
#include <vector>

namespace midair::haptics
{

/// Places points along the chains in equal steps of at least the edge spacing. \a shift (0 .. 1):
/// offset of the first point from the chain's start, in steps; 0: from corner to corner.
void placeChains(SampleBuilder& builder, const std::vector<FeatureChain>& chains, double shift);

/// Fills the gaps that placeChains() leaves: afterwards no place on a feature edge is farther
/// than 1.05 edge spacings from a point.
void fillEdges(SampleBuilder& builder);

/// Tries about 40 area/spacing^2 random points on the faces, weighted by area. If points of \a
/// earlier sets are given, tries those farthest from them first.
void throwDarts(SampleBuilder& builder, std::mt19937_64& random, const PointGrid* earlier);

/// Fills the gaps that throwDarts() leaves: afterwards no place on the surface is farther than 1.05
/// spacings from a point.
void fillFaces(SampleBuilder& builder);

} // namespace midair::haptics
