#pragma once

#include <cstddef>

namespace midair::base
{

// The most that a scene or a caller may ask for, in one place. What exceeds a limit is refused with
// a message that names the number and the limit. They are chosen so that the largest array of the
// kit (3984 transducers) stays below 1.5 GB, and that no step of the work that cannot be broken off
// takes longer than some 50 ms of one core.

/// Control points of one field: G in single precision is then 160 MB.
constexpr int kMostControlPoints = 5000;
/// Entries of G, points times transducers, for arrays larger than those.
constexpr std::size_t kMostEntries = 40000000;
/// Control points for methods that need matrices of points times points in double precision, 16 MB
/// each, and their inverse.
constexpr int kMostDensePoints = 1000;
/// Control points that a certificate is made for: its relaxation keeps some sqrt(n) vectors for
/// each of n points.
constexpr int kMostCertifiedPoints = 1000;
/// Control points of all fields together that are played in turn: each field keeps its own G, so
/// that it starts warm.
constexpr int kMostPointsInTurn = 20000;
/// Samples of all objects of a scene that are looked through for control points.
constexpr int kMostCandidates = 200000;
/// Samples of all sets of all meshes that are kept, some 150 bytes each.
constexpr int kMostCachedSamples = 2000000;
/// Triangles of one mesh.
constexpr int kMostTriangles = 4000000;
/// Samples along outlines at which their pressure is measured.
constexpr int kMostOutlineSamples = 50000;

} // namespace midair::base
