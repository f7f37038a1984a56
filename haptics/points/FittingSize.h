#pragma once

#include "haptics/points/Workspace.h"
#include "haptics/surface/SurfaceSampler.h"
#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Geometry>

namespace midair::haptics
{

/// A model that is too large for an array's workspace, or too small to be more than a focus.
struct LargeModel
{
    const TriangleMesh& mesh;
    Eigen::Isometry3d pose; ///< mesh -> array frame
    double width_m;         ///< > 0; its size, by which it is scaled
    /// > 0: distance of the points on its faces; 0: their number doesn't grow with the faces
    double spacing_m = 0.0;
    bool mayGrow = false; ///< its size is too small, not too large
};

/// The middle of an array's transducers, and the unit vector that they face on the whole; 0 where
/// they face each other.
struct ArrayFront
{
    Eigen::Vector3d middle;
    Eigen::Vector3d ahead;

    /// \a positions, \a normals: 3 x m, m > 0.
    ArrayFront(const Eigen::Matrix3Xd& positions, const Eigen::Matrix3Xd& normals);
};

/// Returns true if a box of that \a extent_m (array frame, axes as the frame's) fits into the
/// workspace, in front of the middle of the array.
bool hasRoom(const Eigen::Vector3d& extent_m, const Workspace& workspace, const ArrayFront& front);

/// Returns the edge of the largest cube that hasRoom(), to a hundredth of the reach.
double roomInside_m(const Workspace& workspace, const ArrayFront& front);

/// Returns the largest size, 1, 2 or 5 times a power of ten and at most the model's own (unless it
/// may grow), with which its box fits into the workspace in front of the middle of the array, and
/// it has no more than \a maxPoints points; 0: none of at least 1 mm does.
double fittingSize_m(const LargeModel& model,
                     const Workspace& workspace,
                     const ArrayFront& front,
                     int maxPoints);

/// True for a shape whose largest extent is under half a wavelength, so that all of it is within
/// one focus. Points that stand for themselves (triangles of one vertex) are none.
bool isOneFocus(const TriangleMesh& mesh, double wavelength_m);

/// Number of points that a model that is one focus would have if it were \a size_m large, at most
/// \a maxPoints. \a size_m: 0: not known, so that it is \a maxPoints.
int pointsAtSize(const TriangleMesh& mesh,
                 const SamplerOptions& sampling,
                 double size_m,
                 int maxPoints);

} // namespace midair::haptics
