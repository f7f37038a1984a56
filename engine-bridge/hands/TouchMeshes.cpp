#include "engine-bridge/hands/TouchMeshes.h"

#include <algorithm>
#include <utility>

namespace midair::bridge
{

namespace
{

constexpr std::uint64_t kSweep = 60; ///< updates between two looks for what isn't used

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
    std::vector<Made> news;
    {
        const base::Lock lock(_mutex);
        news.swap(_made);
    }
    for (Made& one : news)
    {
        _byMesh[one.meshId] = one.distance;
        const auto entry = _entries.find(one.object);
        if (entry != _entries.end()) keep(entry->second, one);
    }
}

// The old one goes into the bin with the thread, if there is one.
void TouchMeshes::keep(Entry& entry, const Made& made)
{
    if (entry.newest)
    {
        const base::Lock lock(_mutex);
        if (_thread.joinable()) _bin.push_back(std::move(entry.newest));
    }
    entry.newest = made.distance;
    entry.meshId = made.meshId;
    entry.topologyId = made.topologyId;
}

TouchMeshes::Made TouchMeshes::made(const Wanted& wanted)
{
    return {wanted.object,
            wanted.meshId,
            wanted.topologyId,
            std::make_shared<const MeshDistance>(wanted.mesh.get(), wanted.like.get())};
}

std::shared_ptr<const MeshDistance> TouchMeshes::get(const HapticObject& object)
{
    Entry& entry = _entries[object.id];
    entry.lastUse = _updates;
    if (entry.newest && entry.meshId == object.meshId) return entry.newest;
    const auto known = _byMesh.find(object.meshId);
    if (auto shared = known != _byMesh.end() ? known->second.lock() : nullptr)
    {
        keep(entry, {object.id, object.meshId, object.topologyId, std::move(shared)});
        return entry.newest;
    }
    const bool isLike = object.topologyId != 0 && object.topologyId == entry.topologyId;
    Wanted wanted{
        object.id, object.meshId, object.topologyId, object.mesh, isLike ? entry.newest : nullptr};
    const std::size_t bytes = object.mesh.bytes();
    if (bytes > _budget)
    {
        submit(std::move(wanted));
        return entry.newest;
    }
    _budget -= bytes;
    keep(entry, made(wanted));
    _byMesh[object.meshId] = entry.newest;
    return entry.newest;
}

void TouchMeshes::submit(Wanted wanted)
{
    {
        const base::Lock lock(_mutex);
        const auto isSame = [&](const auto& other) { return other.meshId == wanted.meshId; };
        if (_atWork == wanted.meshId || std::any_of(_wanted.begin(), _wanted.end(), isSame) ||
            std::any_of(_made.begin(), _made.end(), isSame))
            return;
        const auto older =
            std::find_if(_wanted.begin(),
                         _wanted.end(),
                         [&](const Wanted& other) { return other.object == wanted.object; });
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
        _atWork = next.meshId;
        lock.unlock();
        unused.clear();
        Made one = made(next);
        next = {};
        lock.lock();
        _atWork = 0;
        _made.push_back(std::move(one));
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
