#pragma once

#include "engine-bridge/HapticObject.h"
#include "haptics/surface/SurfaceSampler.h"

#include <Eigen/Core>

#include <cstdint>
#include <list>
#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// The corners of the bounding box of \a points; all zero for none.
Eigen::Matrix<double, 3, 8> boxCorners(const Eigen::Matrix3Xd& points);

/// Points of one mesh, kept while the mesh is about.
struct CachedSamples
{
    /// Each on all of the mesh, each in the gaps of those before it; one, or as many as were asked
    /// for.
    std::vector<haptics::SurfaceSamples> sets;
    Eigen::Matrix<double, 3, 8>
        corners;       ///< of the mesh's bounding box, to tell how far a pose moves it
    std::string error; ///< empty, or why the mesh can't be sampled; there are no sets then
};

/// Samples each mesh once per spacing and kind of sampling. Where the triangles are the same and
/// only the vertices have moved (morphing, skinning, scaling) the points follow by their
/// barycentrics, and are sampled anew once an edge under one of them has become kStretched times
/// longer or shorter.
class SampleCache
{
public:
    /// Valid until endSnapshot(). \a spacing_m > 0. \a sets >= 1 shifted sets of points; vertices
    /// have one only.
    const CachedSamples& get(const HapticObject& object, double spacing_m, int sets = 1);

    /// Sampling that \a stop breaks off throws base::Stopped.
    void setStop(const base::StopToken& stop) { _stop = stop; }

    /// Forgets what has not been asked for in kKeptSnapshots snapshots.
    void endSnapshot();

    std::uint64_t sampled() const { return _sampled; }
    std::uint64_t followed() const { return _followed; }

    static constexpr int kKeptSnapshots = 100;
    static constexpr std::size_t kMostEntries =
        64; ///< beyond, what this snapshot doesn't need goes at once
    static constexpr double kStretched = 1.25;

private:
    struct Entry
    {
        std::uint64_t meshId = 0;
        std::uint64_t topologyId = 0;
        double spacing_m = 0.0;
        int sets = 1;
        haptics::Sampling sampling = haptics::Sampling::SURFACE;
        CachedSamples cached;
        std::shared_ptr<const haptics::TriangleMesh> sampledMesh; ///< as it was when sampled
        int unused = 0;
    };

    bool follow(const Entry& from, const HapticObject& object, Entry& to);
    void sample(const HapticObject& object, Entry& entry);
    bool makeRoom(const Entry& entry);

    base::StopToken _stop;
    std::list<Entry> _entries; ///< few: as many as there are different meshes
    std::uint64_t _sampled = 0;
    std::uint64_t _followed = 0;
};

} // namespace midair::bridge
