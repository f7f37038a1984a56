#include "plugin/scene/TaggedObstacles.h"

#include "engine-bridge/hands/Obstacles.h"
#include "plugin/scene/SceneMarks.h"

namespace osgMidair
{

using midair::bridge::Capsule;

void TaggedObstacles::beginFrame()
{
    _props.clear();
    _idleBefore.swap(_idle);
    _idle.clear();
    _meshes.beginFrame();
    for (auto& [mesh, fit] : _fits)
        ++fit.unusedFrames;
}

void TaggedObstacles::add(osg::Node& node,
                          const Eigen::Matrix4d& toArray,
                          const std::function<bool(const osg::Node&)>& skip,
                          std::vector<std::string>& warnings)
{
    if (!_extract.skip) _extract.skip = skip;
    const bool hasPlace = _meshes.get(node, toArray, _extract, _parts, warnings);
    if (_parts.empty()) tellIdle(node, hasPlace, warnings);
    for (const midair::bridge::CachedMesh& part : _parts)
    {
        const auto [found, fresh] = _fits.try_emplace(part.meshId);
        Fit& fit = found->second;
        if (fresh) fit.capsules = midair::bridge::capsulesOf(*part.mesh);
        fit.unusedFrames = 0;
        for (const Capsule& capsule : fit.capsules)
            _props.push_back({part.pose * capsule.a, part.pose * capsule.b, capsule.radius_m});
    }
}

void TaggedObstacles::tellIdle(osg::Node& node, bool hasPlace, std::vector<std::string>& warnings)
{
    _idle.insert(&node);
    if (_idleBefore.count(&node) > 0) return;
    if (!hasPlace)
        warnings.emplace_back(
            "its matrix is singular, not finite or a perspective; it is no obstacle");
    else if (const WhyUnfelt why = whyUnfelt(node, !warnings.empty()); !why.text.empty())
        warnings.push_back(why.text + "; it is no obstacle");
}

void TaggedObstacles::endFrame()
{
    _meshes.endFrame();
    for (auto fit = _fits.begin(); fit != _fits.end();)
        fit = fit->second.unusedFrames > midair::bridge::MeshCache::kKeptFrames ? _fits.erase(fit)
                                                                                : std::next(fit);
}

void TaggedObstacles::addTo(std::vector<Capsule>& props) const
{
    props.insert(props.end(), _props.begin(), _props.end());
}

} // namespace osgMidair
