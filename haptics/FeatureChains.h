#pragma once

#include "haptics/MeshTopology.h"
#include "haptics/TriangleMesh.h"

#include <vector>

namespace midair::haptics
{

/// Feature edges one after another, from corner to corner or round in a loop.
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

/// Corners: where feature edges end, meet, or turn by more than the crease angle, and tips like a cone's. Sharpest
/// first, by the angle deficit: convex tips come before notches; ties by vertex number.
std::vector<int>
findCorners(const TriangleMesh& mesh, const MeshTopology& topology, double creaseAngle_rad);

/// All feature edges, each in exactly one chain.
std::vector<FeatureChain> chainFeatures(const TriangleMesh& mesh,
                                        const MeshTopology& topology,
                                        const std::vector<int>& corners);

} // namespace midair::haptics
