#pragma once

#include "haptics/array/TransducerArray.h"
#include "haptics/boards/BoardMeasurements.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <string>
#include <vector>

namespace midair::haptics
{

/// Options of fitBoards(); isValid() names the first that is out of range.
struct BoardFitOptions
{
    double sigma_m = 1e-3; ///< 1e-6 .. 0.1; standard deviation of a distance, and of a time's way
    double soundSpeed_m_s = 343.2; ///< 200 .. 500; turns times into distances
    double mostUncertain_m = 5e-3; ///< > 0; what is known worse counts as not determined

    bool isValid(std::string* error = nullptr) const;
};

/// Where a board was found.
struct BoardPose
{
    int board = 0;
    int measurements = 0; ///< that it is in, without those that were left out
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity(); ///< from where the array has it
    double moved_m = 0.0;                                     ///< of its middle
    double turned_deg = 0.0;
    double uncertain_m = 0.0;   ///< standard deviation of its middle, in the worst direction
    double uncertain_deg = 0.0; ///< likewise of its direction
};

/// What fitBoards() has found.
struct BoardFitReport
{
    bool usable = false;   ///< false: array is as it was, and problems say why
    TransducerArray array; ///< with the boards where they were found
    std::vector<BoardPose> boards;
    std::vector<MeasuredPlace> places; ///< those known about, where they were found
    double delay_s = 0.0;              ///< of all times
    Eigen::VectorXd residuals_m;       ///< of each measurement: fitted minus measured
    std::vector<char> leftOut;         ///< 1: contradicts the others
    double noise_m = 0.0;              ///< sqrt(sum r^2 / (measurements - unknowns))
    std::vector<std::string> problems; ///< what makes it unusable
    std::vector<std::string> notes;    ///< what one should know: mirror images, what was left out
};

/// Finds rigid motions of the boards of \a array, and of the places that are known about, from
/// distances and times, by robust least squares from where the array has them. Without known places
/// the whole stays where it is, on average over all transducers; with some, at least three not in
/// one line, these say where it is.
///
/// Refuses, with names: boards without measurements, and what the measurements don't determine to
/// mostUncertain_m; measurements that contradict each other, unless it is at most one in ten, which
/// are left out. Distances don't tell mirror images apart: what is nearer to the array is taken,
/// and notes tell of a board that could as well be elsewhere. Throws base::InputError for options
/// that are not valid, and for known places that are too few.
BoardFitReport fitBoards(const TransducerArray& array,
                         const BoardMeasurements& measurements,
                         const BoardFitOptions& options);

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
