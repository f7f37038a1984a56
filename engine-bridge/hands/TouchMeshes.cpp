#include "engine-bridge/hands/TouchMeshes.h"

#include <algorithm>
#include <utility>

namespace midair::bridge
{

namespace
{

constexpr std::uint64_t kSweep = 60; ///< updates between two cleanups of unused meshes

} // namespace

TouchMeshes::~TouchMeshes()
{
    {
        const base::Lock lock(_mutex);
        _stop = true;
    }
    _wake.notifyAll();
    if (_thread.joinable()) _thread.join();
}

void TouchMeshes::beginUpdate()
{
    ++_updates;
    _budget = kAtOnce;
    std::vector<Prepared> news;
    {
        const base::Lock lock(_mutex);
        news.swap(_made);
    }
    for (const Prepared& one : news)
    {
        _byMesh[one.meshId] = one.distance;
        const auto entry = _entries.find(one.object);
        if (entry != _entries.end()) keep(entry->second, one);
    }
}

// With a thread, the old one goes into its bin.
void TouchMeshes::keep(Entry& entry, Prepared made)
{
    if (entry.newest.distance)
    {
        const base::Lock lock(_mutex);
        if (_thread.joinable()) _bin.push_back(std::move(entry.newest.distance));
    }
    entry.newest = std::move(made);
}

std::shared_ptr<const MeshDistance> TouchMeshes::get(const HapticObject& object)
{
    Entry& entry = _entries[object.id];
    const Prepared& newest = entry.newest;
    entry.lastUse = _updates;
    if (newest.distance && newest.meshId == object.meshId) return newest.distance;
    Prepared what{object.id, object.meshId, object.topologyId, _byMesh[object.meshId].lock()};
    const bool isLike = object.topologyId != 0 && object.topologyId == newest.topologyId;
    const std::shared_ptr<const MeshDistance> like = isLike ? newest.distance : nullptr;
    if (!what.distance)
    {
        const std::size_t bytes = object.mesh.bytes();
        if (bytes > _budget)
        {
            submit({what, object.mesh, like});
            return newest.distance;
        }
        _budget -= bytes;
        what.distance = std::make_shared<const MeshDistance>(object.mesh.get(), like.get());
        _byMesh[object.meshId] = what.distance;
    }
    keep(entry, std::move(what));
    return newest.distance;
}

void TouchMeshes::submit(Wanted wanted)
{
    {
        const base::Lock lock(_mutex);
        const auto isSame = [&](const Prepared& other)
        { return other.meshId == wanted.what.meshId; };
        const auto isWanted = [&](const Wanted& other) { return isSame(other.what); };
        if (_atWork == wanted.what.meshId ||
            std::any_of(_wanted.begin(), _wanted.end(), isWanted) ||
            std::any_of(_made.begin(), _made.end(), isSame))
            return;
        const auto older = std::find_if(_wanted.begin(),
                                        _wanted.end(),
                                        [&](const Wanted& other)
                                        { return other.what.object == wanted.what.object; });
        if (older != _wanted.end())
            *older = std::move(wanted);
        else
            _wanted.push_back(std::move(wanted));
    }
    if (!_thread.joinable()) _thread = std::thread([this] { run(); });
    _wake.notifyAll();
}

void TouchMeshes::run()
{
    base::Lock lock(_mutex);
    for (;;)
    {
        while (!_stop && _wanted.empty() && _bin.empty())
            _wake.wait(lock);
        if (_stop) return;
        std::vector<std::shared_ptr<const MeshDistance>> unused;
        unused.swap(_bin);
        if (_wanted.empty())
        {
            lock.unlock();
            unused.clear();
            lock.lock();
            continue;
        }
        Wanted next = std::move(_wanted.front());
        _wanted.erase(_wanted.begin());
        _atWork = next.what.meshId;
        lock.unlock();
        unused.clear();
        next.what.distance = std::make_shared<const MeshDistance>(next.mesh.get(), next.like.get());
        Prepared made = std::move(next.what);
        next = {};
        lock.lock();
        _atWork = 0;
        _made.push_back(std::move(made));
    }
}

void TouchMeshes::endUpdate()
{
    if (_updates % kSweep != 0) return;
    for (auto entry = _entries.begin(); entry != _entries.end();)
        entry = entry->second.lastUse + kKept < _updates ? _entries.erase(entry) : std::next(entry);
    for (auto mesh = _byMesh.begin(); mesh != _byMesh.end();)
        mesh = mesh->second.expired() ? _byMesh.erase(mesh) : std::next(mesh);
}

} // namespace midair::bridge
