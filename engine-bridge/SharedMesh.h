#pragma once

#include "haptics/surface/TriangleMesh.h"

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <type_traits>
#include <utility>

namespace midair::bridge
{

/// A shared, immutable mesh that is made when first used: a deforming mesh is made on the thread
/// that samples it, or never if a newer one comes first. May be null. Copies share the mesh; any
/// number of threads may use it.
class SharedMesh
{
public:
    using Mesh = haptics::TriangleMesh;

    SharedMesh() = default;
    SharedMesh(std::nullptr_t) {} // NOLINT(google-explicit-constructor): as a shared_ptr has
    /// Takes an existing mesh.
    template<class M,
             class = std::enable_if_t<
                 std::is_convertible_v<std::shared_ptr<M>, std::shared_ptr<const Mesh>>>>
    SharedMesh(std::shared_ptr<M> mesh) // NOLINT(google-explicit-constructor): as above
    {
        if (!mesh) return;
        _state = std::make_shared<State>();
        _state->mesh = std::move(mesh);
        _state->bytes = bytesOf(*_state->mesh);
    }

    /// \a make is called at most once, by the first user, and then released. \a bytes: approximate
    /// size of its input.
    static SharedMesh later(std::function<Mesh()> make, std::size_t bytes)
    {
        SharedMesh result;
        result._state = std::make_shared<State>();
        result._state->make = std::move(make);
        result._state->bytes = bytes;
        return result;
    }

    explicit operator bool() const { return _state != nullptr; }
    const Mesh& operator*() const { return *get(); }
    const Mesh* operator->() const { return get().get(); }
    /// Returns the mesh; makes it if necessary.
    const std::shared_ptr<const Mesh>& get() const
    {
        static const std::shared_ptr<const Mesh> none;
        if (!_state) return none;
        State& state = *_state;
        std::call_once(state.made,
                       [&state]
                       {
                           if (!state.make) return;
                           state.mesh = std::make_shared<const Mesh>(state.make());
                           state.make = nullptr;
                       });
        return state.mesh;
    }

    /// Approximate size, made or not: large meshes should be processed on another thread. 0 for
    /// null.
    std::size_t bytes() const { return _state ? _state->bytes : 0; }
    long useCount() const { return _state.use_count(); }
    bool operator==(const SharedMesh& other) const { return _state == other._state; }
    bool operator!=(const SharedMesh& other) const { return _state != other._state; }

private:
    /// State shared by the copies.
    struct State
    {
        std::once_flag made;
        std::function<Mesh()> make; ///< empty: the mesh is there
        std::shared_ptr<const Mesh> mesh;
        std::size_t bytes = 0;
    };

    static std::size_t bytesOf(const Mesh& mesh)
    {
        return static_cast<std::size_t>(mesh.vertices.size()) * sizeof(double) +
               static_cast<std::size_t>(mesh.triangles.size()) * sizeof(int);
    }

    std::shared_ptr<State> _state;
};

} // namespace midair::bridge
