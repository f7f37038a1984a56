#include "engine-bridge/pipeline/SampleCache.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"

#include <string>

#include <fmt/format.h>

namespace midair::bridge
{

Eigen::Matrix<double, 3, 8> boxCorners(const Eigen::Matrix3Xd& points)
{
    Eigen::Matrix<double, 3, 8> corners = Eigen::Matrix<double, 3, 8>::Zero();
    if (points.cols() == 0) return corners;
    const Eigen::Vector3d low = points.rowwise().minCoeff();
    const Eigen::Vector3d high = points.rowwise().maxCoeff();
    for (int i = 0; i < 8; ++i)
        for (int k = 0; k < 3; ++k)
            corners(k, i) = ((i >> k) & 1) ? high[k] : low[k];
    return corners;
}

namespace
{

/// True if an edge of a sampled triangle has changed its length by more than the factor \a limit.
bool stretched(const haptics::SurfaceSamples& samples,
               const haptics::TriangleMesh& before,
               const haptics::TriangleMesh& now,
               double limit)
{
    for (const int t : samples.triangle)
        for (int k = 0; k < 3; ++k)
        {
            const int a = before.triangles(k, t);
            const int b = before.triangles((k + 1) % 3, t);
            const double was = (before.vertices.col(b) - before.vertices.col(a)).squaredNorm();
            const double is = (now.vertices.col(b) - now.vertices.col(a)).squaredNorm();
            // Written so that NaN counts as stretched.
            if (!(is <= limit * limit * was && was <= limit * limit * is)) return true;
        }
    return false;
}

} // namespace

bool SampleCache::follow(const Entry& from, const HapticObject& object, Entry& to)
{
    const haptics::TriangleMesh& before = *from.sampledMesh;
    const haptics::TriangleMesh& now = *object.mesh;
    if (before.triangles.cols() != now.triangles.cols() ||
        before.vertices.cols() != now.vertices.cols() || !from.cached.error.empty() ||
        stretched(from.cached.sets.front(), before, now, kStretched))
        return false;
    to.cached.sets = from.cached.sets;
    to.cached.sampling = from.cached.sampling;
    to.sampledMesh = from.sampledMesh;
    for (haptics::SurfaceSamples& samples : to.cached.sets)
        haptics::updateSamples(now, samples);
    ++_followed;
    return true;
}

void SampleCache::sample(const HapticObject& object, Entry& entry)
{
    haptics::SamplerOptions options;
    options.spacing_m = entry.spacing_m;
    options.sampling = entry.sampling;
    options.stop = _stop;
    entry.sampledMesh = object.mesh.get();
    entry.cached.sampling = ++_sampled;
    try
    {
        const bool one = options.sampling == haptics::Sampling::VERTICES ||
                         options.sampling == haptics::Sampling::POINTS;
        entry.cached.sets = haptics::sampleSurfaceSets(*object.mesh, options, one ? 1 : entry.sets);
        if (!makeRoom(entry))
            throw base::InputError(fmt::format(
                "with it the scene's meshes have more than {} samples in the sets of their points",
                base::kMostCachedSamples));
    }
    catch (const base::InputError& error)
    {
        entry.cached.sets.clear();
        entry.cached.error = error.what();
    }
}

// Drops entries that this snapshot doesn't use if the samples exceed the limit; false if they still
// do.
bool SampleCache::makeRoom(const Entry& entry)
{
    const auto samplesOf = [](const Entry& one)
    {
        Eigen::Index count = 0;
        for (const haptics::SurfaceSamples& set : one.cached.sets)
            count += set.size();
        return count;
    };
    const auto all = [&]
    {
        Eigen::Index count = samplesOf(entry);
        for (const Entry& one : _entries)
            count += samplesOf(one);
        return count;
    };
    if (all() <= base::kMostCachedSamples) return true;
    _entries.remove_if([](const Entry& one) { return one.unused > 0; });
    return all() <= base::kMostCachedSamples;
}

const CachedSamples& SampleCache::get(const HapticObject& object, double spacing_m, int sets)
{
    const haptics::Sampling sampling = object.properties.sampling;
    const Entry* alike = nullptr;
    for (Entry& entry : _entries)
    {
        if (entry.spacing_m != spacing_m || entry.sampling != sampling || entry.sets != sets)
            continue;
        if (entry.meshId == object.meshId)
        {
            entry.unused = 0;
            return entry.cached;
        }
        // the first match is the newest
        if (!alike && object.topologyId != 0 && entry.topologyId == object.topologyId)
            alike = &entry;
    }
    Entry entry;
    entry.meshId = object.meshId;
    entry.topologyId = object.topologyId;
    entry.spacing_m = spacing_m;
    entry.sampling = sampling;
    entry.sets = sets;
    if (!alike || !follow(*alike, object, entry)) sample(object, entry);
    for (Entry& one : _entries)
        one.isShape |= object.topologyId != 0 && one.topologyId == object.topologyId;
    entry.cached.corners = entry.cached.sets.empty()
                               ? boxCorners(Eigen::Matrix3Xd(3, 0))
                               : boxCorners(entry.cached.sets.front().positions);
    _entries.push_front(std::move(entry));
    return _entries.front().cached;
}

void SampleCache::endSnapshot()
{
    const bool isFull = _entries.size() > kMostEntries;
    _entries.remove_if(
        [isFull](Entry& entry)
        {
            const int kept = entry.isShape ? kKeptShapes : kKeptSnapshots;
            return entry.unused++ > (isFull ? 0 : kept);
        });
}

} // namespace midair::bridge
