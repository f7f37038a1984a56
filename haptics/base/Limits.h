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
/// Fields of a cycle, and subsets of the points, that are played in turn.
constexpr int kMostCycle = 64;
constexpr int kMostSubsets = 64;
/// Between one field of a cycle and the next.
constexpr int kMostCycleSteps = 16;
/// Hz; fields that follow each other: no transducer's carrier (40 kHz) carries more.
constexpr double kMostFieldRate_Hz = 40e3;
/// Hz; of an amplitude modulation: beyond, the skin feels nothing and the ear all the more.
constexpr double kMostModulation_Hz = 500.0;
/// s; between two looks of the monitor.
constexpr double kLeastMonitorInterval_s = 0.05;
constexpr double kMostMonitorInterval_s = 1e6;

} // namespace midair::base
