#pragma once

#include "haptics/array/TransducerArray.h"

#include <string>
#include <vector>

namespace midair::haptics
{

/// Options of planBoards().
struct BoardPlanOptions
{
    double longest_m = 1.0; ///< 0.01 .. 10; of the tape
    double sigma_m = 1e-3;  ///< 1e-6 .. 0.1; what a distance is measured to
    /// 0 .. 10,000; number of distances; 0: one and a half times as many as there are unknowns
    int count = 0;
};

/// A distance to measure.
struct PlannedDistance
{
    std::string from, to; ///< corners, as BoardMarks names them
    int fromTransducer = 0, toTransducer = 0;
    double distance_m = 0.0; ///< where the boards are where the array has them
};

/// What to measure so that fitBoards() finds all boards.
struct BoardPlan
{
    std::vector<PlannedDistance> distances;
    double uncertain_m = 0.0; ///< then, of the worst known board's middle; infinite: not determined
    std::vector<std::string> problems; ///< what these distances leave undetermined, by board
};

/// Chooses distances between corners of different boards, greedily: always the one whose length is
/// known worst from those before it (D-optimal design), so that every board is held from all sides.
/// Throws base::InputError for an array of one board and options out of range.
BoardPlan planBoards(const TransducerArray& array, const BoardPlanOptions& options);

} // namespace midair::haptics
