#pragma once

#include <cstddef>

namespace midair::base
{

// Limits on requests of scenes and callers. Input beyond a limit is refused with a message that
// names the number and the limit. Within these limits the largest array of the kit (3984
// transducers) needs less than 1.5 GB, and no uninterruptible step takes more than about 50 ms on
// one core.

/// Control points of one field: 160 MB for G in single precision.
constexpr int kMostControlPoints = 5000;
/// Entries of G, points times transducers, for larger arrays.
constexpr std::size_t kMostEntries = 40000000;
/// Control points for methods with complex points x points matrices in double precision, 16 MB
/// each, and their inverse.
constexpr int kMostDensePoints = 1000;
/// Control points of a certificate: its relaxation stores about sqrt(n) numbers for each of n
/// points.
constexpr int kMostCertifiedPoints = 1000;
/// Control points of all fields in turn together: each field keeps its own G for a warm start.
constexpr int kMostPointsInTurn = 20000;
/// Samples of all objects of a scene, from which control points are selected.
constexpr int kMostCandidates = 200000;
/// Cached samples of all sets of all meshes, about 150 bytes each.
constexpr int kMostCachedSamples = 2000000;
/// Triangles of one mesh.
constexpr int kMostTriangles = 4000000;
/// Samples along outlines for measuring the pressure.
constexpr int kMostOutlineSamples = 50000;

// Ranges checked by several layers.

/// Air: range in which the sound formulas hold.
constexpr double kLeastTemperature_C = -40.0;
constexpr double kMostTemperature_C = 60.0;
constexpr double kLeastAirPressure_Pa = 50e3;
constexpr double kMostAirPressure_Pa = 120e3;
/// Solver options.
constexpr double kMostLoudness = 2.0;
constexpr int kMostThreads = 256;
/// Largest pressure cap, peak Pa.
constexpr double kMostPressure_Pa = 1e6;
/// Range of the ear limit, dB re 20 uPa, rms. Values below the least are mistakes: 0 means no
/// limit, while its neighbours would mean near silence.
constexpr double kLeastEarLimit_dB = 20.0;
constexpr double kMostEarLimit_dB = 200.0;
/// Fields of a cycle, and subsets of the points, in turn.
constexpr int kMostCycle = 64;
constexpr int kMostSubsets = 64;
/// Intermediate steps from one field of a cycle to the next.
constexpr int kMostCycleSteps = 16;
/// Passes for evening out a cycle.
constexpr int kMostEven = 1000;
/// Hz; rate of fields in turn: one per period of the 40 kHz carrier.
constexpr double kMostFieldRate_Hz = 40e3;
/// Hz; amplitude modulation. Above it the skin feels little and the ear hears more.
constexpr double kMostModulation_Hz = 500.0;
/// s; between two measurements of the monitor.
constexpr double kLeastMonitorInterval_s = 0.05;
constexpr double kMostMonitorInterval_s = 1e6;

} // namespace midair::base
