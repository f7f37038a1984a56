#pragma once

#include "engine-bridge/SceneSnapshot.h"
#include "haptics/SurfaceSampler.h"

#include <Eigen/Core>

#include <cstdint>
#include <list>
#include <string>

namespace midair::bridge
{

/// Points of one mesh, kept while the mesh is about.
struct CachedSamples
{
    haptics::SurfaceSamples samples;
    Eigen::Matrix<double, 3, 8>
        corners;       ///< of the mesh's bounding box, to tell how far a pose moves it
    std::string error; ///< empty, or why the mesh can't be sampled; samples are then empty
};

/// Samples each mesh once per spacing and kind of sampling.
class SampleCache
{
public:
    /// Valid until endSnapshot(). \a spacing_m > 0.
    const CachedSamples& get(const HapticObject& object, double spacing_m);

    /// Forgets what has not been asked for in kKeptSnapshots snapshots.
    void endSnapshot();

    std::uint64_t sampled() const { return _sampled; }

    static constexpr int kKeptSnapshots = 100;

private:
    struct Entry
    {
        std::uint64_t meshId;
        double spacing_m;
        haptics::Sampling sampling;
        CachedSamples cached;
        int unused = 0;
    };

    static CachedSamples sample(const HapticObject& object, double spacing_m);

    std::list<Entry> _entries; ///< few: as many as there are different meshes
    std::uint64_t _sampled = 0;
};

} // namespace midair::bridge
