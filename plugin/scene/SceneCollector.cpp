#include "plugin/scene/SceneCollector.h"

#include "engine-bridge/scene/Convert.h"
#include "plugin/scene/PropertyConversion.h"

#include <fmt/format.h>

namespace osgMidair
{

using midair::bridge::HapticObject;
using midair::bridge::MeshCache;

SceneCollector::SceneCollector(const osg::Node* owner,
                               std::function<void(const std::string&)> say) :
    _say(std::move(say)),
    _visitor(owner)
{
    _extract.skip = isOwnObject; // nested haptic nodes are separate objects
}

void SceneCollector::configure(const Eigen::Matrix4d& toArray, bool shadows)
{
    _toArray = toArray;
    _shadows = shadows;
    forget();
}

bool SceneCollector::collect(osg::Node& root,
                             const osg::Matrixd& world,
                             std::vector<HapticObject>& objects)
{
    _objects = &objects;
    _count = 0;
    _felt = 0;
    _changed = !_kept;
    ++_frame;
    if (_tagFrame == 0) markTags(root);
    _tagFrame = (_tagFrame + 1) % kTagFrames;
    _visitor.collect(root, world, _default ? &*_default : nullptr);
    _meshes.beginFrame();
    _obstacles.beginFrame();
    for (const HapticInstance& instance : _visitor.instances())
        if (instance.obstacle)
            fillObstacle(instance);
        else
            fill(instance);
    _obstacles.endFrame();
    _meshes.endFrame();
    if (objects.size() != _count) _changed = true;
    objects.resize(_count);
    _kept = true;
    if (_frame % MeshCache::kKeptFrames == 0) forgetUnseen();
    return _changed;
}

void SceneCollector::forgetUnseen()
{
    for (auto known = _known.begin(); known != _known.end();)
        known = _frame - known->second.seen > MeshCache::kKeptFrames ? _known.erase(known)
                                                                     : std::next(known);
}

osg::Node* SceneCollector::nodeOf(std::uint64_t instance) const
{
    const auto known = _known.find(instance);
    return known == _known.end() ? nullptr : known->second.node.get();
}

void SceneCollector::sayWarnings(const std::string& path)
{
    for (const std::string& warning : _warnings)
        _say(fmt::format("{}: {}", path, warning));
}

void SceneCollector::fillObstacle(const HapticInstance& instance)
{
    if (!_shadows)
    {
        if (!_obstacles.saidIdle)
            _say(_visitor.path(instance) +
                 ": is an obstacle, which counts only where the scene's shadows are on");
        _obstacles.saidIdle = true;
        return;
    }
    _warnings.clear();
    if (instance.inWorld)
        _obstacles.add(*instance.node,
                       _toArray * midair::bridge::toEigen(instance.world),
                       _extract.skip,
                       _warnings);
    else
        _warnings.emplace_back("hangs on a camera, not in the world; it is no obstacle");
    if (!_warnings.empty()) sayWarnings(_visitor.path(instance));
}

SceneCollector::Known&
SceneCollector::know(const HapticInstance& instance, bool& fresh, bool& changed)
{
    const auto [found, inserted] = _known.try_emplace(instance.id);
    Known& known = found->second;
    fresh = inserted;
    changed = inserted || known.seen + 1 != _frame;
    known.seen = _frame;
    if (inserted) known.path = _visitor.path(instance);
    if (inserted) known.node = instance.node;

    HapticProperty raw;
    if (instance.property)
    {
        if (!inserted && *instance.property == known.raw) return known;
        raw = *instance.property;
    }
    else
    {
        std::string tag;
        hapticTag(*instance.node, tag);
        if (!inserted && tag == known.tag) return known;
        known.tag = tag;
        std::vector<std::string> errors;
        raw.parse(tag, errors);
        for (const std::string& error : errors)
            _say(known.path + ": " + error);
        if (!inserted && raw == known.raw) return known;
    }
    changed = true;
    known.raw = known.property = raw;
    for (const std::string& what : known.property.repair())
        _say(known.path + ": " + what);
    return known;
}

void SceneCollector::fill(const HapticInstance& instance)
{
    bool fresh = false;
    bool changed = false;
    Known& known = know(instance, fresh, changed);
    std::uint64_t shape = 0;
    const bool possible = known.property.enabled && instance.inWorld;
    if (possible)
    {
        _extract.paint = paintOf(known.property);
        _warnings.clear();
        shape = _meshes.look(*instance.node, _extract, _warnings);
        if (!_warnings.empty()) sayWarnings(known.path);
    }
    const bool stands = _kept && !changed && known.first == _count && known.shape == shape &&
                        known.world == instance.world;
    known.shape = shape;
    if (!stands)
    {
        _changed = true;
        known.world = instance.world;
        known.first = _count;
        known.count = 0;
        if (known.property.enabled && !instance.inWorld && fresh)
            _say(known.path + ": hangs on a camera, not in the world; it can't be felt");
        if (possible && instance.followsCamera && fresh)
            _say(known.path +
                 ": hangs on what turns with the camera on screen; it is felt unturned");
        if (possible) fillParts(instance, known);
    }
    _count += known.count;
    if (known.count > 0) ++_felt;
}

void SceneCollector::fillParts(const HapticInstance& instance, Known& known)
{
    _warnings.clear();
    const Eigen::Matrix4d matrix = _toArray * midair::bridge::toEigen(instance.world);
    if (!_meshes.get(*instance.node, matrix, _extract, _parts, _warnings))
    {
        _say(known.path +
             ": its matrix is singular, not finite or a perspective; it can't be felt");
        return;
    }
    sayWarnings(known.path);
    if (_parts.empty())
    {
        _say(known.path + ": has no triangles; it can't be felt");
        return;
    }
    known.count = _parts.size();
    if (_objects->size() < _count + known.count) _objects->resize(_count + known.count);
    for (std::size_t i = 0; i < known.count; ++i)
    {
        const midair::bridge::CachedMesh& part = _parts[i];
        HapticObject& object = (*_objects)[_count + i];
        object.id = instance.id ^ part.part;
        object.whole = instance.id;
        object.path = known.path;
        object.meshId = part.meshId;
        object.topologyId = part.topologyId;
        object.mesh = part.mesh;
        object.pose = part.pose;
        object.properties = forBridge(known.property);
        object.touchEvents = known.property.touchEvents;
    }
}

} // namespace osgMidair
