#pragma once

#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// All points within a radius of the segment from a to b that goes evenly from aRadius_m to
/// bRadius_m: a bone with its flesh.
struct RoundCone
{
    Eigen::Vector3d a = Eigen::Vector3d::Zero(); ///< metres
    Eigen::Vector3d b = Eigen::Vector3d::Zero(); ///< metres; may be a: a ball
    double aRadius_m = 0.0;                      ///< > 0
    double bRadius_m = 0.0;                      ///< > 0
};

/// Returns the distance, m, from \a place (metres) to the surface of all \a cones together (at
/// least one); below 0 inside.
double distanceTo(const std::vector<RoundCone>& cones, const Eigen::Vector3d& place);

/// Returns the surface of all \a cones together as a closed mesh, counter-clockwise from outside,
/// of triangles as alike as can be: the zero level of the distance on tetrahedra of a body-centred
/// cubic lattice of \a cell_m (> 0), whose points move onto the surface where that passes near, so
/// that no slivers appear (Labelle, Shewchuk 2007, 10.1145/1275808.1276448), and then evened out.
/// Parts thinner than a cell may be lost. Throws InputError for no cones, for such as aren't finite
/// or have no radius, and for a lattice of more than 10^7 points.
TriangleMesh roundBody(const std::vector<RoundCone>& cones, double cell_m);

/// Returns the finest such mesh of at most \a mostTriangles (>= 100), to some percent.
TriangleMesh finestRoundBody(const std::vector<RoundCone>& cones, Eigen::Index mostTriangles);

} // namespace midair::haptics
