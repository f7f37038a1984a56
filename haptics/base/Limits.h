#pragma once

#include <cstddef>

namespace midair::base
{

// What a scene or a caller may ask for at most, in one place: beyond, work is refused with a
// message that names the number and the limit. Chosen so that the largest array of the kit (3984
// transducers) stays below 1.5 GB, and that no step of the work that can't be broken off takes
// longer than some 50 ms of one core.

/// Of one field: G in single precision is 160 MB.
constexpr int kMostControlPoints = 5000;
/// Entries of G, points times transducers, for arrays larger than those.
constexpr std::size_t kMostEntries = 40000000;
/// Of solvers that need matrices of points times points in double precision, 16 MB each, and their
/// inverse.
constexpr int kMostDensePoints = 1000;
/// That a certificate is made for: its relaxation keeps some sqrt(n) vectors for each of n points.
constexpr int kMostCertifiedPoints = 1000;
/// Of fields that are played in turn, together: each keeps its own G, so that it starts warm.
constexpr int kMostPointsInTurn = 20000;
/// Samples of all objects of a scene that are looked through for control points.
constexpr int kMostCandidates = 200000;
/// Samples of all sets of all meshes that are kept, some 150 bytes each.
constexpr int kMostCachedSamples = 2000000;
/// Of one mesh.
constexpr int kMostTriangles = 4000000;
/// Of outlines, where their pressure is judged.
constexpr int kMostOutlineSamples = 50000;

} // namespace midair::base
