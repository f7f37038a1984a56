#pragma once

#include "haptics/points/Workspace.h"
#include "haptics/surface/SurfaceSampler.h"
#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Geometry>

namespace midair::haptics
{

/// A model that is too large for an array's workspace, or too small for more than one focus.
struct LargeModel
{
    const TriangleMesh& mesh;
    Eigen::Isometry3d pose; ///< mesh -> array frame
    double width_m;         ///< > 0; its size, the unit of scaling
    /// > 0: spacing of points on its faces; 0: the number of points doesn't depend on its size
    double spacing_m = 0.0;
    bool mayGrow = false; ///< its size is too small, not too large
};

/// Middle of an array's transducers, and the unit vector of their common direction; 0 if they face
/// each other.
struct ArrayFront
{
    Eigen::Vector3d middle;
    Eigen::Vector3d ahead;

    /// \a positions, \a normals: 3 x m, m > 0.
    ArrayFront(const Eigen::Matrix3Xd& positions, const Eigen::Matrix3Xd& normals);
};

/// Returns true if a box of \a extent_m (aligned with the array frame) fits into the workspace, in
/// front of the middle of the array.
bool hasRoom(const Eigen::Vector3d& extent_m, const Workspace& workspace, const ArrayFront& front);

/// Returns the edge of the largest cube with hasRoom(), to 1 % of the reach.
double roomInside_m(const Workspace& workspace, const ArrayFront& front);

/// Returns the largest size, 1, 2 or 5 times a power of ten and at most the model's own (unless it
/// may grow), at which its box fits into the workspace in front of the middle of the array and it
/// has at most \a maxPoints points; 0 if no size of at least 1 mm fits.
double fittingSize_m(const LargeModel& model,
                     const Workspace& workspace,
                     const ArrayFront& front,
                     int maxPoints);

/// Size at which an object is felt best, m: a larger one has more points, each of them weaker.
constexpr double kFeltBest_m = 0.08;

/// Returns the size to propose to a user where \a fitting_m is the largest that fits (0: none).
double proposedSize_m(double fitting_m);

/// Returns true if the shape's largest extent is under half a wavelength, so that it is within one
/// focus. False for isolated points (triangles of one vertex).
bool isOneFocus(const TriangleMesh& mesh, double wavelength_m);

/// Returns the number of points, at most \a maxPoints, that a single-focus model would have at \a
/// size_m. \a size_m 0: unknown, gives \a maxPoints.
int pointsAtSize(const TriangleMesh& mesh,
                 const SamplerOptions& sampling,
                 double size_m,
                 int maxPoints);

} // namespace midair::haptics
