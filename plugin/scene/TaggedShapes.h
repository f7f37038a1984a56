#pragma once

#include "engine-bridge/scene/MeshCache.h"
#include "haptics/surface/TriangleMesh.h"
#include "plugin/scene/SceneMarks.h"

#include <osg/Node>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <functional>
#include <iterator>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace osgMidair
{

/// Turns nodes tagged as real things into a \a Fit for each of their meshes: what the sound of an
/// array meets there. For the update thread; a frame without changed shapes allocates nothing.
template<typename Fit>
class TaggedShapes
{
public:
    using Make = Fit (*)(const midair::haptics::TriangleMesh&);

    /// \a make fits a mesh, in its frame. \a isNone ends the sentence that tells why a node has no
    /// mesh: "it is no obstacle".
    TaggedShapes(Make make, const char* isNone) : _make(make), _isNone(isNone) {}

    void beginFrame()
    {
        _idleBefore.swap(_idle);
        _idle.clear();
        _meshes.beginFrame();
        for (auto& [mesh, known] : _known)
            ++known.unusedFrames;
    }

    /// Calls \a take(fit, pose) for each mesh of \a node; pose: mesh -> array. \a toArray:
    /// transform from the frame of its children to the array. Leaves out subtrees for which \a skip
    /// returns true.
    template<typename Take>
    void add(osg::Node& node,
             const Eigen::Matrix4d& toArray,
             const std::function<bool(const osg::Node&)>& skip,
             std::vector<std::string>& warnings,
             const Take& take)
    {
        if (!_extract.skip) _extract.skip = skip;
        const bool hasPlace = _meshes.get(node, toArray, _extract, _parts, warnings);
        if (_parts.empty()) tellIdle(node, hasPlace, warnings);
        for (const midair::bridge::CachedMesh& part : _parts)
        {
            const auto [found, fresh] = _known.try_emplace(part.meshId);
            if (fresh) found->second.fit = _make(*part.mesh);
            found->second.unusedFrames = 0;
            take(found->second.fit, part.pose);
        }
    }

    void endFrame()
    {
        _meshes.endFrame();
        for (auto known = _known.begin(); known != _known.end();)
            known = known->second.unusedFrames > midair::bridge::MeshCache::kKeptFrames
                        ? _known.erase(known)
                        : std::next(known);
    }

private:
    struct Known
    {
        Fit fit; ///< mesh frame
        int unusedFrames = 0;
    };

    /// Logs once why \a node has no shape, while that is so.
    void tellIdle(osg::Node& node, bool hasPlace, std::vector<std::string>& warnings)
    {
        _idle.insert(&node);
        if (_idleBefore.count(&node) > 0) return;
        if (!hasPlace)
            warnings.push_back(
                std::string("its matrix is singular, not finite or a perspective; ") + _isNone);
        else if (const WhyUnfelt why = whyUnfelt(node, !warnings.empty()); !why.text.empty())
            warnings.push_back(why.text + "; " + _isNone);
    }

    const Make _make;
    const char* const _isNone;
    std::set<const osg::Node*> _idle; ///< without a mesh in this frame; only compared
    std::set<const osg::Node*> _idleBefore;
    midair::bridge::MeshCache _meshes{false}; ///< what is unknown neither blocks nor reflects sound
    midair::bridge::ExtractOptions _extract;
    std::vector<midair::bridge::CachedMesh> _parts;
    std::unordered_map<std::uint64_t, Known> _known; ///< by mesh
};

} // namespace osgMidair
