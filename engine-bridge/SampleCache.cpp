#include "engine-bridge/SampleCache.h"

#include "haptics/InputError.h"

namespace midair::bridge
{

namespace
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

} // namespace

CachedSamples SampleCache::sample(const HapticObject& object, double spacing_m)
{
    CachedSamples cached;
    haptics::SamplerOptions options;
    options.spacing_m = spacing_m;
    options.sampling = object.properties.sampling;
    try
    {
        cached.samples = haptics::sampleSurface(*object.mesh, options);
    }
    catch (const haptics::InputError& error)
    {
        cached.samples = {};
        cached.error = error.what();
    }
    cached.corners = boxCorners(cached.samples.positions);
    return cached;
}

const CachedSamples& SampleCache::get(const HapticObject& object, double spacing_m)
{
    const haptics::Sampling sampling = object.properties.sampling;
    for (Entry& entry : _entries)
    {
        if (entry.meshId != object.meshId || entry.spacing_m != spacing_m ||
            entry.sampling != sampling)
            continue;
        entry.unused = 0;
        return entry.cached;
    }
    _entries.push_front({object.meshId, spacing_m, sampling, sample(object, spacing_m), 0});
    ++_sampled;
    return _entries.front().cached;
}

void SampleCache::endSnapshot()
{
    _entries.remove_if([](Entry& entry) { return ++entry.unused > kKeptSnapshots; });
}

} // namespace midair::bridge
