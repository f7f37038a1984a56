#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>

namespace midair::base
{

/// Returns the number of forks that led to this process; a child's number differs from its
/// parent's. A child has only the thread that called fork(): other threads don't exist there, and
/// their locks may stay locked.
std::uint64_t forks() noexcept;

/// Message of a forked child for everything that its parent plays.
inline constexpr const char* kForked =
    "closed: the program has forked, and its parent plays on; make a new one in this process";

/// Knows whether this is the process that created it.
class MadeHere
{
public:
    MadeHere() : _forks(forks()) {}
    explicit operator bool() const { return _forks == forks(); }

private:
    std::uint64_t _forks;
};

/// Owns an object with threads, locks or a device. In a forked child the object is the parent's and
/// is not destroyed, because that would wait for threads that don't exist and write to the parent's
/// device; a new object replaces it. Any thread.
template<typename T>
class OfProcess
{
public:
    /// \a make creates an object; \a isFirst is false if it replaces another process's.
    explicit OfProcess(std::function<std::unique_ptr<T>(bool isFirst)> make) :
        _make(std::move(make)),
        _held(new Held{MadeHere(), _make(true)})
    {
    }
    ~OfProcess()
    {
        const Held* held = _held;
        if (held->isOurs) delete held;
    }
    OfProcess(const OfProcess&) = delete;
    OfProcess& operator=(const OfProcess&) = delete;

    T& operator*() const
    {
        Held* held = _held;
        if (held->isOurs) return *held->what;
        auto* fresh = new Held{MadeHere(), _make(false)};
        if (_held.compare_exchange_strong(held, fresh)) return *fresh->what;
        delete fresh; // another thread was first
        return *held->what;
    }
    T* operator->() const { return &**this; }

private:
    struct Held
    {
        MadeHere isOurs;
        std::unique_ptr<T> what;
    };

    const std::function<std::unique_ptr<T>(bool)> _make;
    mutable std::atomic<Held*> _held;
};

/// Destroys \a of if \a isOurs says that this process created it; otherwise leaks it.
template<typename Owner>
void dropOrLeave(const MadeHere& isOurs, Owner& of)
{
    if (!isOurs) new Owner(std::move(of));
}

} // namespace midair::base
