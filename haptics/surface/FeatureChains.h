#pragma once

#include "haptics/surface/MeshTopology.h"
#include "haptics/surface/Outline.h"
#include "haptics/surface/TriangleMesh.h"

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
/// crease angle, and tips like that of a cone. Sorted by falling angle deficit, so that convex tips
/// come before notches; ties by vertex number.
std::vector<int>
findCorners(const TriangleMesh& mesh, const MeshTopology& topology, double creaseAngle_rad);

/// Joins all feature edges to chains; each edge is in exactly one chain.
std::vector<FeatureChain> chainFeatures(const TriangleMesh& mesh,
                                        const MeshTopology& topology,
                                        const std::vector<int>& corners);

/// Returns the feature edges of \a mesh as curves in its own frame, from corner to corner or around
/// a loop; \a points (may be null): the number of the mesh's points, which are on no curve.
/// Vertices are welded as by sampleSurface() with \a spacing_m. Throws InputError as that does with
/// EDGES, Stopped if \a stop requests it.
std::vector<Outline> featureOutlines(const TriangleMesh& mesh,
                                     double creaseAngle_rad,
                                     double spacing_m,
                                     const base::StopToken& stop = {},
                                     int* points = nullptr);

} // namespace midair::haptics
