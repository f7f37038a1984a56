#pragma once

#include "tests/referee/Recompute.h"

#include <map>
#include <set>
#include <string>

namespace midair::referee
{

/// The most that a figure may differ, as a part of itself; counts must be equal.
constexpr double kMostOff = 0.01;

/// A figure below this counts as being this large, since all products are in single precision: of
/// fields for up to \a points points each from \a transducers.
double floorOf(const std::string& figure, int points = 0, int transducers = 1);

/// Figures that can't be recomputed from what was played: times, and how the field was found.
extern const std::set<std::string> kNotRecomputed;

/// The report's largest difference from what was recomputed, of one figure.
struct Worst
{
    double off = 0.0; ///< |told - truth| / max(|truth|, floor)
    double told = 0.0, truth = 0.0;
    double apart = 0.0; ///< largest |told - truth|, perhaps of another update
    int update = 0;
    int failures = 0; ///< updates in which off > kMostOff, or a count is another one
};

/// What comes out of one recording.
struct Verdict
{
    std::map<std::string, Worst> figures;
    std::set<std::string> missing; ///< figures of reports that nobody recomputed
    int updates = 0, skipped = 0;
    double rmsAdded = 0.0; ///< most that kept rows add to rms: at the places asked for, less told
    /// That may be as much as a wave's phase turns over the skip tolerance, rad.
    double mostAdded = 0.0;
    double rmsAsked = 0.0; ///< the largest rms at the places asked for, where rows were kept
    double worstMove_m = 0.0;
    double overCap = 0.0; ///< largest pressure at a point over the cap; 0: there is no cap

    bool passed() const;
    int failures() const;
};

/// Compares every figure of every report with its recomputation.
Verdict judge(const Recorded& recorded);

} // namespace midair::referee
