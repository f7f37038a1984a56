#pragma once

#include "haptics/base/threads/StopToken.h"
#include "haptics/points/Workspace.h"
#include "haptics/surface/Outline.h"
#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Geometry>

#include <vector>

namespace midair::haptics
{

/// The feature edges of a mesh in the array's frame, by whether the array reaches them. A field for
/// outlines has no points to leave out, so one that is reached in part isn't reached.
struct ReachedOutlines
{
    std::vector<Outline> inside; ///< reached from one end to the other
    int outside = 0;             ///< number of the others
    int apart = 0;               ///< number of the mesh's points, which are on no outline
    double points = 0.0;         ///< half a wavelength apart along those inside
};

/// Sorts the outlines of \a mesh, which \a pose takes to the array's frame and whose target is
/// \a target, by \a workspace. Outlines of more than base::kMostControlPoints points half a
/// wavelength apart count as outside. Throws as featureOutlines() does.
ReachedOutlines reachedOutlines(const TriangleMesh& mesh,
                                const Eigen::Isometry3d& pose,
                                double target,
                                const Workspace& workspace,
                                const base::StopToken& stop = {});

} // namespace midair::haptics
