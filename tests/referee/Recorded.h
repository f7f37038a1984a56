#pragma once

#include "device/drive/DriveSignal.h"
#include "haptics/array/Medium.h"
#include "haptics/solvers/SolveReport.h"
#include "haptics/surface/TriangleMesh.h"
#include "tests/referee/Scene.h"

#include <Eigen/Geometry>

#include <memory>
#include <string>
#include <vector>

namespace midair::referee
{

/// One of the fields that an update plays, in turn if there are several.
struct Part
{
    haptics::ControlPoints points; ///< that the field is for
    std::size_t field = 0;         ///< index into Recorded::fields
    /// Which rows of G it was solved with: the same number for the parts of which one solver keeps
    /// the rows from update to update.
    int rows = 0;
};

/// One update: what was asked for, what the product said of it, and what its device was sent.
struct Update
{
    std::vector<Part> parts; ///< K >= 1
    haptics::SolveReport report;
    /// The pipeline found that nothing had moved, and gave the result of the update before again.
    bool isRepeat = false;
    /// The sets of the updates before, played in turn now that nothing moves: the set of the last
    /// one wasn't solved for again.
    bool isJoined = false;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity(); ///< of the mesh, when it was assembled
};

/// A moving scene as the recording device kept it.
struct Recorded
{
    haptics::TransducerArray array;
    haptics::Medium medium;
    double skipTolerance_m = 0.0; ///< how far a point moves before its row of G is built anew
    double fieldRate_Hz = 0.0;
    double cap_Pa = 0.0;
    std::shared_ptr<const haptics::TriangleMesh> mesh; ///< what is felt; null: points only
    std::vector<Update> updates;
    std::vector<device::DriveSignal> fields; ///< levels, decoded from the file
};

/// Plays \a updates updates of \a scene into \a file through `record:`, and reads the file back.
/// Throws std::runtime_error if the file does not hold every field that the device took, or not
/// those that results say are played, in their order.
Recorded record(const Scene& scene, int updates, const std::string& file);

} // namespace midair::referee
