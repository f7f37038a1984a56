#pragma once

#include "engine-bridge/HapticObject.h"
#include "engine-bridge/hands/MeshDistance.h"
#include "haptics/base/threads/Mutex.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <thread>
#include <unordered_map>
#include <vector>

namespace midair::bridge
{

/// The MeshDistance of each object that hands may touch. Small meshes are prepared when they are
/// asked for; large ones on a thread of its own, of each object the newest, and until that is there
/// the one before serves. Only one thread at a time may call its members.
class TouchMeshes
{
public:
    /// As many bytes of meshes (SharedMesh::bytes()) are prepared at once in an update.
    static constexpr std::size_t kAtOnce = std::size_t(1) << 16;

    TouchMeshes() = default;
    ~TouchMeshes(); ///< waits for the mesh that is being prepared

    TouchMeshes(const TouchMeshes&) = delete;
    TouchMeshes& operator=(const TouchMeshes&) = delete;

    void beginUpdate();
    /// Returns that of the newest mesh of \a object that is prepared; null if none is. \a object
    /// has a mesh.
    std::shared_ptr<const MeshDistance> get(const HapticObject& object);
    void endUpdate(); ///< drops what was not asked for in as many as kKept updates

    static constexpr std::uint64_t kKept = 600;

private:
    /// A mesh of an object, to be prepared or prepared.
    struct Prepared
    {
        std::uint64_t object = 0; ///< HapticObject::id
        std::uint64_t meshId = 0;
        std::uint64_t topologyId = 0;
        std::shared_ptr<const MeshDistance> distance; ///< null: not yet
    };
    struct Wanted
    {
        Prepared what;
        SharedMesh mesh;
        std::shared_ptr<const MeshDistance> like; ///< of the same triangles; null: none
    };
    /// What there is of an object.
    struct Entry
    {
        Prepared newest;
        std::uint64_t lastUse = 0;
    };

    void keep(Entry& entry, Prepared made);
    void submit(Wanted wanted);
    void run();

    std::unordered_map<std::uint64_t, Entry> _entries; ///< by HapticObject::id
    /// by meshId: objects may share a mesh
    std::unordered_map<std::uint64_t, std::weak_ptr<const MeshDistance>> _byMesh;
    std::uint64_t _updates = 0;
    std::size_t _budget = 0; ///< bytes that are left of kAtOnce

    base::Mutex _mutex;
    base::Condition _wake;
    /// at most one of each object, in the order that they came
    std::vector<Wanted> _wanted MIDAIR_GUARDED_BY(_mutex);
    /// meshId of the one that is being prepared
    std::uint64_t _atWork MIDAIR_GUARDED_BY(_mutex) = 0;
    std::vector<Prepared> _made MIDAIR_GUARDED_BY(_mutex); ///< not taken yet
    /// large ones that nobody needs any more: freeing megabytes takes longer than a frame should
    std::vector<std::shared_ptr<const MeshDistance>> _bin MIDAIR_GUARDED_BY(_mutex);
    bool _stop MIDAIR_GUARDED_BY(_mutex) = false;
    std::thread _thread; ///< runs once there was a large mesh
};

} // namespace midair::bridge
