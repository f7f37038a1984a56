#pragma once

#include "haptics/surface/MeshTopology.h"
#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// Sequence of feature edges from corner to corner, or around a loop.
struct FeatureChain
{
    struct Step
    {
        int edge;      ///< index into MeshTopology::features
        bool reversed; ///< runs from FeatureEdge::to to FeatureEdge::from
    };

    std::vector<Step> steps;
    /// m, steps + 1 values: length up to the start of each step, then the total
    std::vector<double> arc;
    bool closed = false; ///< a loop without a corner

    double length() const { return arc.back(); }
};

/// Returns the corners: welded vertices where feature edges end, meet, or turn by more than the
/// crease angle, and tips like that of a cone. Sorted by decreasing angle deficit, so convex tips
/// come before notches; ties by vertex number.
std::vector<int>
findCorners(const TriangleMesh& mesh, const MeshTopology& topology, double creaseAngle_rad);

/// Joins all feature edges into chains; each edge is in exactly one chain.
std::vector<FeatureChain> chainFeatures(const TriangleMesh& mesh,
                                        const MeshTopology& topology,
                                        const std::vector<int>& corners);

/// Touchable curve: a polyline in the array frame.
struct Outline
{
    Eigen::Matrix3Xd vertices; ///< 3 x k, metres; k >= 2, or >= 3 if closed
    bool closed = false;       ///< the last vertex is joined to the first
    double target = 1.0;       ///< > 0; sound pressure along it, relative to other outlines

    /// Returns the length of the polyline, m. Throws InputError for too few vertices, a vertex that
    /// is not finite, or a length of 0.
    double length_m() const;

    /// Returns points at equal steps of at most \a spacing_m (> 0) along the polyline, including
    /// both ends if it is open, starting at the first vertex if it is closed. Corners need not get
    /// points. Throws as length_m(), and for more than 100,000 points.
    Eigen::Matrix3Xd points(double spacing_m) const;

    /// Returns a circle of \a diameter_m around \a centre, perpendicular to \a axis (any non-zero
    /// length), as a polygon with \a corners >= 3.
    static Outline circle(const Eigen::Vector3d& centre,
                          double diameter_m,
                          const Eigen::Vector3d& axis,
                          int corners = 720);
    static Outline line(const Eigen::Vector3d& from, const Eigen::Vector3d& to);
};

/// Returns the feature edges of \a mesh as curves in its own frame, from corner to corner or around
/// a loop; \a points (may be null): number of the mesh's points, which are on no curve. Welds
/// vertices as sampleSurface() does with \a spacing_m. Throws InputError as that does with EDGES,
/// Stopped if \a stop requests it.
std::vector<Outline> featureOutlines(const TriangleMesh& mesh,
                                     double creaseAngle_rad,
                                     double spacing_m,
                                     const base::StopToken& stop = {},
                                     int* points = nullptr);

/// Estimates the number of points of all \a outlines without placing them; infinite for a spacing
/// of 0. Throws InputError for an outline without length.
double pointsAlong(const std::vector<Outline>& outlines, double spacing_m);

} // namespace midair::haptics
