#pragma once

#include <cstddef>

namespace midair::base
{

// Limits on what a scene or a caller may ask for. Input beyond a limit is refused with a message
// that names the number and the limit. With these limits the largest array of the kit (3984
// transducers) needs less than 1.5 GB, and no step that can't be interrupted takes more than some
// 50 ms on one core.

/// Control points of one field: G in single precision is then 160 MB.
constexpr int kMostControlPoints = 5000;
/// Entries of G, points times transducers, for larger arrays than that.
constexpr std::size_t kMostEntries = 40000000;
/// Control points for methods that need complex matrices of points times points in double
/// precision, 16 MB each, and their inverse.
constexpr int kMostDensePoints = 1000;
/// Control points that a certificate is made for: its relaxation stores some sqrt(n) numbers for
/// each of n points.
constexpr int kMostCertifiedPoints = 1000;
/// Control points of all fields together that are played in turn: each field keeps its own G for a
/// warm start.
constexpr int kMostPointsInTurn = 20000;
/// Samples of all objects of a scene among which control points are selected.
constexpr int kMostCandidates = 200000;
/// Cached samples of all sets of all meshes, some 150 bytes each.
constexpr int kMostCachedSamples = 2000000;
/// Triangles of one mesh.
constexpr int kMostTriangles = 4000000;
/// Samples along outlines at which the pressure is measured.
constexpr int kMostOutlineSamples = 50000;

// Limits of ranges that several layers check.

/// The air: range in which the formulas for sound hold.
constexpr double kLeastTemperature_C = -40.0;
constexpr double kMostTemperature_C = 60.0;
constexpr double kLeastAirPressure_Pa = 50e3;
constexpr double kMostAirPressure_Pa = 120e3;
/// Solver options.
constexpr double kMostLoudness = 2.0;
constexpr int kMostThreads = 256;
/// Largest pressure cap, peak Pa.
constexpr double kMostPressure_Pa = 1e6;
/// dB re 20 uPa, rms: limits of the level at ears. Below the least one a limit is a slip: 0 is
/// none, and nearly silence are its neighbours.
constexpr double kLeastEarLimit_dB = 20.0;
constexpr double kMostEarLimit_dB = 200.0;
/// Fields of a cycle, and subsets of the points, played in turn.
constexpr int kMostCycle = 64;
constexpr int kMostSubsets = 64;
/// Intermediate steps from one field of a cycle to the next.
constexpr int kMostCycleSteps = 16;
/// Passes that even a cycle out.
constexpr int kMostEven = 1000;
/// Hz; rate of fields played in turn: one per period of the 40 kHz carrier.
constexpr double kMostFieldRate_Hz = 40e3;
/// Hz; amplitude modulation: at higher frequencies the skin feels little and the ear hears more.
constexpr double kMostModulation_Hz = 500.0;
/// s; between two fields that the monitor examines.
constexpr double kLeastMonitorInterval_s = 0.05;
constexpr double kMostMonitorInterval_s = 1e6;

} // namespace midair::base
