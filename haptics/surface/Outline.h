#pragma once

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// Curve that is felt as a line: a polyline in the array frame.
struct Outline
{
    Eigen::Matrix3Xd vertices; ///< 3 x k, metres; k >= 2, or >= 3 where closed
    bool closed = false;       ///< the last vertex is joined to the first
    double target = 1.0;       ///< > 0; sound pressure along it, relative to other outlines

    /// Returns the length of the polyline, m. Throws InputError for too few vertices, one that is
    /// not finite, or a length of 0.
    double length_m() const;

    /// Returns points at equal steps of at most \a spacing_m (> 0) along the polyline, including
    /// both ends if it is open, starting at the first vertex if it is closed. There need not be
    /// points at corners. Throws as length_m(), and for more than 100,000 points.
    Eigen::Matrix3Xd points(double spacing_m) const;

    /// Returns a circle of \a diameter_m around \a centre, perpendicular to \a axis (of any length
    /// but 0), as a polygon with \a corners >= 3.
    static Outline circle(const Eigen::Vector3d& centre,
                          double diameter_m,
                          const Eigen::Vector3d& axis,
                          int corners = 720);
    static Outline line(const Eigen::Vector3d& from, const Eigen::Vector3d& to);
};

/// Estimates the number of points of all \a outlines without placing any; infinite for a spacing of
/// 0. Throws InputError for an outline without length.
double pointsAlong(const std::vector<Outline>& outlines, double spacing_m);

} // namespace midair::haptics
