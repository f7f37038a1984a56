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
    double sigma_m = 1e-3; ///< 1e-6 .. 0.1; standard deviation of a distance, also of one from a
                           ///< time
    double soundSpeed_m_s = 343.2; ///< 200 .. 500; converts times to distances
    double mostUncertain_m = 5e-3; ///< > 0; poses with a larger uncertainty count as undetermined

    bool isValid(std::string* error = nullptr) const;
};

/// Fitted pose of a board.
struct BoardPose
{
    int board = 0;
    int measurements = 0;                                     ///< used measurements of this board
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity(); ///< from its pose in the array
    double moved_m = 0.0;                                     ///< displacement of its middle
    double turned_deg = 0.0;
    double uncertain_m = 0.0;   ///< standard deviation of its middle in the worst direction
    double uncertain_deg = 0.0; ///< likewise of its direction
};

/// Result of fitBoards().
struct BoardFitReport
{
    bool usable = false;   ///< false: array is unchanged, and problems give the reasons
    TransducerArray array; ///< with the boards at their fitted poses
    std::vector<BoardPose> boards;
    std::vector<MeasuredPlace> places; ///< approximately known places, at their fitted positions
    double delay_s = 0.0;              ///< common to all times
    Eigen::VectorXd residuals_m;       ///< fitted minus measured, for each measurement
    std::vector<char> leftOut;         ///< 1: contradicts the others and was left out
    double noise_m = 0.0;              ///< sqrt(sum r^2 / (measurements - unknowns))
    std::vector<std::string> problems; ///< reasons why it is not usable
    std::vector<std::string> notes;    ///< hints: mirror images, measurements left out
};

/// Fits rigid motions of the boards of \a array, and the positions of approximately known places,
/// to distances and times by robust least squares from their present poses. Without known places,
/// the mean motion over all transducers is zero; with at least three known places, not in one line,
/// these define the frame.
///
/// Refuses, naming them: boards without measurements, poses not determined to mostUncertain_m, and
/// contradicting measurements, unless they are at most one in ten, which are then left out.
/// Distances can't distinguish mirror images: the one nearer to the array's pose is used, and notes
/// name boards with a second solution. Throws base::InputError for invalid options and too few
/// known places.
BoardFitReport fitBoards(const TransducerArray& array,
                         const BoardMeasurements& measurements,
                         const BoardFitOptions& options);

/// Options of planBoards().
struct BoardPlanOptions
{
    double longest_m = 1.0; ///< 0.01 .. 10; length of the tape
    double sigma_m = 1e-3;  ///< 1e-6 .. 0.1; accuracy of a distance
    /// 0 .. 10,000; number of distances; 0: 1.5 times the number of unknowns
    int count = 0;
};

/// A distance to measure.
struct PlannedDistance
{
    std::string from, to; ///< corners, named as by BoardMarks
    int fromTransducer = 0, toTransducer = 0;
    double distance_m = 0.0; ///< for the array's present poses
};

/// Distances to measure so that fitBoards() can find all boards.
struct BoardPlan
{
    std::vector<PlannedDistance> distances;
    double uncertain_m = 0.0;          ///< then of the middle of the least certain board; infinite:
                                       ///< undetermined
    std::vector<std::string> problems; ///< undetermined boards after these measurements
};

/// Chooses distances between corners of different boards, greedily: always the one whose length is
/// least known from those before it (D-optimal design), so that each board is held from all sides.
/// Throws base::InputError for an array of one board and options out of range.
BoardPlan planBoards(const TransducerArray& array, const BoardPlanOptions& options);

} // namespace midair::haptics
