#pragma once

#include "engine-bridge/c/midair.h"
#include "haptics/base/threads/Mutex.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <string>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace midair::capi
{

/// Reason and status of a failing call of the C interface.
class Failure : public std::exception
{
public:
    Failure(midair_status status, std::string text) : _status(status), _text(std::move(text)) {}

    midair_status status() const { return _status; }
    const char* what() const noexcept override { return _text.c_str(); }

private:
    midair_status _status;
    std::string _text;
};

/// Forgets this thread's last error.
void beginCall() noexcept;
/// To be called in a handler of all exceptions: stores the exception as this thread's last error
/// and returns its status.
midair_status caught() noexcept;
/// Stores why a call gave silence, and returns MIDAIR_SILENT.
midair_status silentFor(const std::string& why);

/// Runs the body of a function of the C interface, which returns its status or void (MIDAIR_OK).
/// Catches all exceptions.
template<typename Body>
midair_status called(const Body& body) noexcept
{
    beginCall();
    try
    {
        if constexpr (std::is_void_v<decltype(body())>)
        {
            body();
            return MIDAIR_OK;
        }
        else
            return body();
    }
    catch (...)
    {
        return caught();
    }
}

[[noreturn]] void fail(midair_status status, const std::string& text);

/// Dereferences \a pointer; fails if it is null. \a name: of the argument.
template<typename T>
T& given(T* pointer, const char* name)
{
    if (!pointer) fail(MIDAIR_INVALID, std::string(name) + " is NULL");
    return *pointer;
}

/// Returns a text argument; fails if it is null or longer than \a most bytes.
std::string textGiven(const char* text, const char* name, std::size_t most = 1 << 16);

/// Fails unless all of \a count numbers are finite; \a each: numbers per item, for the message.
void requireFinite(const double* numbers,
                   std::size_t count,
                   const char* name,
                   std::size_t each = 1);

/// Writes \a text with its terminator into \a room of \a size bytes, and the size that it takes
/// into \a needed (may be null). Fails with MIDAIR_TOO_SMALL; a size of 0 only queries.
midair_status writeText(const std::string& text, char* room, std::size_t size, std::size_t* needed);

/// While one exists, this thread runs a callback of the application, which may not call functions
/// with a scene: it would deadlock.
class CallbackScope
{
public:
    CallbackScope() noexcept;
    ~CallbackScope();
    CallbackScope(const CallbackScope&) = delete;
    CallbackScope& operator=(const CallbackScope&) = delete;

    static bool isInside() noexcept;
};

/// Generates unique numbers for handles of all kinds; never an address.
inline std::uintptr_t nextHandle()
{
    static std::atomic<std::uintptr_t> next{1};
    return next++;
}

/// The objects behind handles of one kind. A handle is looked up, never dereferenced, so a closed
/// handle or one of another kind is an error, not a memory fault. Any thread.
template<typename Handle, typename Object>
class Handles
{
public:
    /// \a kind: "midair_scene", for error messages.
    explicit Handles(const char* kind) : _kind(kind) {}

    Handle* add(std::shared_ptr<Object> object)
    {
        const std::uintptr_t number = nextHandle();
        const base::Lock lock(_mutex);
        _all.emplace(number, std::move(object));
        return reinterpret_cast<Handle*>(number); // NOLINT(performance-no-int-to-ptr)
    }

    /// Fails for an invalid handle.
    std::shared_ptr<Object> find(const Handle* handle) const
    {
        const base::Lock lock(_mutex);
        const auto found = _all.find(reinterpret_cast<std::uintptr_t>(handle));
        if (found == _all.end()) failClosed(handle);
        return found->second;
    }

    /// Closes a handle and returns its object; fails for an invalid handle.
    std::shared_ptr<Object> take(const Handle* handle)
    {
        const base::Lock lock(_mutex);
        const auto found = _all.find(reinterpret_cast<std::uintptr_t>(handle));
        if (found == _all.end()) failClosed(handle);
        std::shared_ptr<Object> object = std::move(found->second);
        _all.erase(found);
        return object;
    }

    /// Replaces \a old by \a fresh; \a old is never freed, because it belongs to another process.
    /// Returns the handle's object afterwards; fails for an invalid handle.
    std::shared_ptr<Object>
    replace(const Handle* handle, const std::shared_ptr<Object>& old, std::shared_ptr<Object> fresh)
    {
        const base::Lock lock(_mutex);
        const auto found = _all.find(reinterpret_cast<std::uintptr_t>(handle));
        if (found == _all.end()) failClosed(handle);
        if (found->second != old) return found->second; // another thread was first
        leave(old);
        found->second = std::move(fresh);
        return found->second;
    }
    /// Leaks \a object on purpose.
    static void leave(const std::shared_ptr<Object>& object)
    {
        new std::shared_ptr<Object>(object); // NOLINT(clang-analyzer-cplusplus.NewDeleteLeaks)
    }

    /// \{ Held while the program forks, so that the guarded data is consistent.
    void lock() MIDAIR_NO_THREAD_ANALYSIS { _mutex.lock(); }
    void unlock() MIDAIR_NO_THREAD_ANALYSIS { _mutex.unlock(); }
    /// \}

    std::vector<std::shared_ptr<Object>> all() const
    {
        const base::Lock lock(_mutex);
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
    mutable base::Mutex _mutex;
    std::unordered_map<std::uintptr_t, std::shared_ptr<Object>> _all MIDAIR_GUARDED_BY(_mutex);
};

/// Fails if a program's struct is smaller than in the version it was built for.
template<typename Struct>
void requireSize(const Struct& of)
{
    if (of.struct_size < sizeof(Struct))
        fail(MIDAIR_INVALID,
             fmt::format("struct_size is {}; it must be the struct's sizeof, {}",
                         of.struct_size,
                         sizeof(Struct)));
}

/// Copies \a all, converted by \a make, into the caller's memory.
template<typename From, typename To, typename Make>
midair_status copyAll(const std::vector<From>& all,
                      To* to,
                      std::size_t capacity,
                      std::size_t* count,
                      const Make& make)
{
    given(count, "count") = all.size();
    if (all.size() > capacity)
        fail(MIDAIR_TOO_SMALL, fmt::format("capacity is {}; there are {}", capacity, all.size()));
    if (!all.empty()) given(to, "the memory to copy to");
    std::transform(all.begin(), all.end(), to, make);
    return MIDAIR_OK;
}

} // namespace midair::capi
