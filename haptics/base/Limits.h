#pragma once

#include <cstddef>

namespace midair::base
{

// What a scene or a caller may ask for at most, in one place: beyond, work is refused with a message that names the number and
// the limit. Chosen so that the largest array of the kit (3984 transducers) stays below 1.5 GB, and that no step of the
// work that can't be broken off takes longer than some 50 ms of one core.

/// Of one field: G in single precision is 160 MB.
constexpr int kMostControlPoints = 5000;
/// Entries of G, points times transducers, for arrays larger than those.
constexpr std::size_t kMostEntries = 40000000;
/// Of solvers that need matrices of points times points in double precision, 16 MB each, and their inverse.
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

// Ends of ranges that several storeys check.

/// Of the air: what the formulas of its sound hold for.
constexpr double kLeastTemperature_C = -40.0;
constexpr double kMostTemperature_C = 60.0;
constexpr double kLeastAirPressure_Pa = 50e3;
constexpr double kMostAirPressure_Pa = 120e3;
/// Of a solver.
constexpr double kMostLoudness = 2.0;
constexpr int kMostThreads = 256;
/// Peak Pa that a cap can be set to.
constexpr double kMostPressure_Pa = 1e6;
/// Of fields, and of subsets of the points, that are played in turn.
constexpr int kMostFieldsInTurn = 64;
/// Between one of them and the next.
constexpr int kMostCycleSteps = 16;
/// Hz; fields that follow each other: no transducer's carrier (40 kHz) carries more.
constexpr double kMostFieldRate_Hz = 40e3;
/// Hz; of an amplitude modulation: above, skin feels no beat.
constexpr double kMostModulation_Hz = 500.0;
/// s; between two looks of the monitor.
constexpr double kMostMonitorInterval_s = 1e6;

} // namespace midair::base
