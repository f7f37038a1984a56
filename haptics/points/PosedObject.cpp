#include "haptics/points/PosedObject.h"

#include <numeric>

namespace midair::haptics
{

void PosedObject::pose(const SurfaceSamples& samples,
                       const Eigen::Isometry3d& meshToArray,
                       std::uint64_t first)
{
    positions.noalias() = meshToArray.linear() * samples.positions;
    positions.colwise() += meshToArray.translation();
    normals.noalias() = meshToArray.linear() * samples.normals;
    intensity = samples.intensity;
    identity.resize(static_cast<std::size_t>(positions.cols()));
    std::iota(identity.begin(), identity.end(), first);
}

void PosedObject::keepIf(const std::function<bool(Eigen::Index)>& isKept)
{
    Eigen::Index kept = 0;
    for (Eigen::Index i = 0; i < positions.cols(); ++i)
    {
        if (!isKept(i)) continue;
        positions.col(kept) = positions.col(i);
        normals.col(kept) = normals.col(i);
        if (intensity.size() > 0) intensity[kept] = intensity[i];
        if (!identity.empty())
            identity[static_cast<std::size_t>(kept)] = identity[static_cast<std::size_t>(i)];
        ++kept;
    }
    positions.conservativeResize(3, kept);
    normals.conservativeResize(3, kept);
    if (intensity.size() > 0) intensity.conservativeResize(kept);
    if (!identity.empty()) identity.resize(static_cast<std::size_t>(kept));
}

} // namespace midair::haptics
