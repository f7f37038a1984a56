#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>

namespace midair::base
{

/// Returns how often the program has forked on the way to this process; in a child it is another
/// number than in its parent. A child has one thread, that which called fork(): whoever has threads
/// of its own, or locks that others take, has them no more there.
std::uint64_t forks() noexcept;

/// What a child says of all that its parent plays.
inline constexpr const char* kForked =
    "closed: the program has forked, and its parent plays on; what plays here has to be made here";

/// Knows whether this is the process that it was made in.
class MadeHere
{
public:
    MadeHere() : _forks(forks()) {}
    explicit operator bool() const { return _forks == forks(); }

private:
    std::uint64_t _forks;
};

/// Owns something with threads, locks or a device, which in the child of a fork is the parent's: it
/// is not destroyed there, which would wait for threads that don't exist, and write to a device
/// that the parent leads. Another one takes its place. Any thread.
template<typename T>
class OfProcess
{
public:
    /// \a make makes one; false: in the place of another process's.
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

/// Destroys \a of if it was made in this process, as \a isOurs says; else it stays for ever.
template<typename Owner>
void dropOrLeave(const MadeHere& isOurs, Owner& of)
{
    if (!isOurs) new Owner(std::move(of));
}

} // namespace midair::base
