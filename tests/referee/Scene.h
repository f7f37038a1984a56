#pragma once

#include "haptics/array/TransducerArray.h"
#include "haptics/points/ControlPoints.h"

#include <Eigen/Geometry>

#include <string>
#include <vector>

namespace midair::referee
{

/// What is solved for, how it moves, and through which part of the product.
struct Scene
{
    std::string name;
    haptics::TransducerArray array;
    /// Before it moves; with \a throughPipeline only its targets' kind counts, see below.
    haptics::ControlPoints points;
    bool phaseOnly = true;
    double loudness = 1.0;
    /// Share by which targets rise and fall again every 40 updates; 0: they stay.
    double swing = 0.0;
    /// True: a mesh of radius_m goes through the live pipeline; its pressure is pressure_Pa, or
    /// relative if that is 0. False: the points go to the production solver.
    bool throughPipeline = false;
    double radius_m = 0.0;
    double pressure_Pa = 0.0;
    double cap_Pa = 0.0; ///< of the pipeline; 0: none
    /// Of the pipeline: where the middle of the mesh is before it moves.
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    int threads = 1;
    /// Of the pipeline, over 1: while the object moves each update takes the next set of points,
    /// and in every tenth update the pipeline has time to play all sets in turn.
    int cycle = 1;
    int subsets = 1;         ///< of the pipeline; over 1: each update is that many fields in turn
    bool isMeasured = false; ///< by the pipeline: every tenth update waits for surface figures
};

/// Scenes that make every figure take several values: equal, unequal, crowded and left out points,
/// targets in Pa that are reached, swing and fall short, amplitudes, a loudness above 1, a device
/// with coarse levels, two threads, the pipeline with and without a cap, with fields in turn (a
/// cycle of shifted points, subsets) and with surface figures.
std::vector<Scene> allScenes();

/// Where the object is in update \a k >= 0. Of twenty updates in a row the first eight are 1 mm and
/// 1 degree apart, the next three 0.1 mm, the last nine 5 nm, which the solver may skip. The path
/// stays within 25 mm of its start.
class Motion
{
public:
    const Eigen::Isometry3d& pose() const { return _pose; }
    void next();

private:
    int _k = 0;
    Eigen::Isometry3d _pose = Eigen::Isometry3d::Identity();
};

/// The scene's points at \a pose about their own centre, in update \a k.
haptics::ControlPoints pointsAt(const Scene& scene, const Eigen::Isometry3d& pose, int k);
/// Factor on the targets in update \a k.
double swingAt(const Scene& scene, int k);

} // namespace midair::referee
