#pragma once

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// A curve that is to be felt as one: a polyline in the array frame.
struct Outline
{
    Eigen::Matrix3Xd vertices; ///< 3 x k, metres; k >= 2, or >= 3 where closed
    bool closed = false;       ///< the last vertex is joined to the first
    double target = 1.0;       ///< > 0; sound pressure along it, relative to other outlines

    /// The length along the polyline, m. Throws InputError for too few vertices, one that is not
    /// finite, or a length of 0.
    double length_m() const;

    /// Points at equal steps of at most \a spacing_m (> 0) along the polyline: both ends of an open
    /// one, a closed one from its first vertex on. Corners between the steps are cut. Throws as
    /// length_m, and for more than 100,000 points.
    Eigen::Matrix3Xd points(double spacing_m) const;

    /// A circle of \a diameter_m about \a centre, perpendicular to \a axis (of any length but 0),
    /// as a polygon of \a corners >= 3.
    static Outline circle(const Eigen::Vector3d& centre,
                          double diameter_m,
                          const Eigen::Vector3d& axis,
                          int corners = 720);
    static Outline line(const Eigen::Vector3d& from, const Eigen::Vector3d& to);
};

/// Estimates how many points \a outlines take together, without placing any; infinite for a spacing
/// of 0. Throws InputError where an outline has no length.
double pointsAlong(const std::vector<Outline>& outlines, double spacing_m);

} // namespace midair::haptics
