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

/// The MeshDistance of each touchable object. Small meshes are prepared on request; large ones on a
/// separate thread, the newest of each object, and until it is ready the one before is used. Only
/// one thread at a time may call its members.
class TouchMeshes
{
public:
    /// Bytes of meshes (SharedMesh::bytes()) that are prepared at once per update.
    static constexpr std::size_t kAtOnce = std::size_t(1) << 16;

    TouchMeshes() = default;
    ~TouchMeshes(); ///< waits for the mesh being prepared

    TouchMeshes(const TouchMeshes&) = delete;
    TouchMeshes& operator=(const TouchMeshes&) = delete;

    void beginUpdate();
    /// Returns that of the newest prepared mesh of \a object; null if there is none. \a object has
    /// a mesh.
    std::shared_ptr<const MeshDistance> get(const HapticObject& object);
    void endUpdate(); ///< drops meshes not requested in the last kKept updates

    static constexpr std::uint64_t kKept = 600;

private:
    /// A mesh of an object, prepared or to be prepared.
    struct Prepared
    {
        std::uint64_t object = 0; ///< HapticObject::id
        std::uint64_t meshId = 0;
        std::uint64_t topologyId = 0;
        std::shared_ptr<const MeshDistance> distance; ///< null: not ready
    };
    struct Wanted
    {
        Prepared what;
        SharedMesh mesh;
        std::shared_ptr<const MeshDistance> like; ///< of the same triangles; null: none
    };
    /// State of an object.
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
    std::size_t _budget = 0; ///< bytes left of kAtOnce

    base::Mutex _mutex;
    base::Condition _wake;
    /// at most one per object, in order of arrival
    std::vector<Wanted> _wanted MIDAIR_GUARDED_BY(_mutex);
    /// meshId of the one being prepared
    std::uint64_t _atWork MIDAIR_GUARDED_BY(_mutex) = 0;
    std::vector<Prepared> _made MIDAIR_GUARDED_BY(_mutex); ///< not taken yet
    /// unused large ones: freeing megabytes takes longer than a frame should
    std::vector<std::shared_ptr<const MeshDistance>> _bin MIDAIR_GUARDED_BY(_mutex);
    bool _stop MIDAIR_GUARDED_BY(_mutex) = false;
    std::thread _thread; ///< runs after the first large mesh
};

} // namespace midair::bridge
