#pragma once

#include "engine-bridge/c/inside/Calls.h"

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace midair::capi
{

/// Numbers for handles of all kinds, so that none is given twice; never an address of anything.
inline std::uintptr_t nextHandle()
{
    static std::atomic<std::uintptr_t> next{1};
    return next++;
}

/// What handles of one kind stand for. A handle is looked up and never followed, so that one that
/// was closed, or is of another kind, is an error and no fault of the memory. Any thread.
template<typename Handle, typename Object>
class Handles
{
public:
    /// \a kind: "midair_scene", for errors.
    explicit Handles(const char* kind) : _kind(kind) {}

    Handle* add(std::shared_ptr<Object> object)
    {
        const std::uintptr_t number = nextHandle();
        const std::unique_lock<std::shared_mutex> lock(_mutex);
        _all.emplace(number, std::move(object));
        return reinterpret_cast<Handle*>(number); // NOLINT(performance-no-int-to-ptr)
    }

    /// Fails for a handle of nothing.
    std::shared_ptr<Object> find(const Handle* handle) const
    {
        const std::shared_lock<std::shared_mutex> lock(_mutex);
        const auto found = _all.find(reinterpret_cast<std::uintptr_t>(handle));
        if (found == _all.end()) failClosed(handle);
        return found->second;
    }

    /// Closes a handle and returns what it stood for; fails for a handle of nothing.
    std::shared_ptr<Object> take(const Handle* handle)
    {
        const std::unique_lock<std::shared_mutex> lock(_mutex);
        const auto found = _all.find(reinterpret_cast<std::uintptr_t>(handle));
        if (found == _all.end()) failClosed(handle);
        std::shared_ptr<Object> object = std::move(found->second);
        _all.erase(found);
        return object;
    }

    std::vector<std::shared_ptr<Object>> all() const
    {
        const std::shared_lock<std::shared_mutex> lock(_mutex);
        std::vector<std::shared_ptr<Object>> objects;
        for (const auto& entry : _all)
            objects.push_back(entry.second);
        return objects;
    }

private:
    [[noreturn]] void failClosed(const Handle* handle) const
    {
        fail(MIDAIR_CLOSED,
             std::string("the ") + _kind + (handle ? " is closed, or none" : " is NULL"));
    }

    const char* _kind;
    mutable std::shared_mutex _mutex;
    std::unordered_map<std::uintptr_t, std::shared_ptr<Object>> _all;
};

} // namespace midair::capi
