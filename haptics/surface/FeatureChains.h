#pragma once

#include "haptics/surface/MeshTopology.h"
#include "haptics/surface/Outline.h"
#include "haptics/surface/TriangleMesh.h"

#include <vector>

namespace midair::haptics
{

/// A row of feature edges, from corner to corner or round in a loop.
struct FeatureChain
{
    struct Step
    {
        int edge;      ///< index into MeshTopology::features
        bool reversed; ///< walked from FeatureEdge::to to FeatureEdge::from
    };

    std::vector<Step> steps;
    std::vector<double> arc; ///< m, steps + 1: length up to each step's start, then the whole
    bool closed = false;     ///< a loop without a corner

    double length() const { return arc.back(); }
};

/// Finds the corners: welded vertices where feature edges end, meet, or turn by more than the
/// crease angle, and tips like that of a cone. Sharpest first, by the angle deficit: convex tips
/// come before notches; ties by vertex number.
std::vector<int>
findCorners(const TriangleMesh& mesh, const MeshTopology& topology, double creaseAngle_rad);

/// Chains all feature edges; each is in exactly one chain.
std::vector<FeatureChain> chainFeatures(const TriangleMesh& mesh,
                                        const MeshTopology& topology,
                                        const std::vector<int>& corners);

/// The feature edges of \a mesh as curves, in its own frame: from corner to corner, or round. Edges
/// shorter than the rounding of the mesh are passed over as by sampleSurface at \a spacing_m.
/// Throws InputError as that does with EDGES. Throws Stopped where \a stop asks for it.
std::vector<Outline> featureOutlines(const TriangleMesh& mesh,
                                     double creaseAngle_rad,
                                     double spacing_m,
                                     const base::StopToken& stop = {});

} // namespace midair::haptics
