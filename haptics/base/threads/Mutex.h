#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>

// Annotations that name the lock of a member or function, so that clang detects missing locks
// (-Wthread-safety, an error with -DMIDAIR_WERROR=ON). g++ ignores them. Source: clang's "Thread
// Safety Analysis".
#ifdef __clang__
#define MIDAIR_THREADS(attribute) __attribute__((attribute))
#else
#define MIDAIR_THREADS(attribute)
#endif
/// A member that is accessed only with `mutex` locked.
#define MIDAIR_GUARDED_BY(mutex) MIDAIR_THREADS(guarded_by(mutex))
/// A pointer whose target is accessed only with `mutex` locked; the pointer itself is not guarded.
#define MIDAIR_PT_GUARDED_BY(mutex) MIDAIR_THREADS(pt_guarded_by(mutex))
/// A function, or a lambda after its brackets, that is called with these locked.
#define MIDAIR_REQUIRES(...) MIDAIR_THREADS(requires_capability(__VA_ARGS__))
/// A function that locks these itself and must not be called with them locked.
#define MIDAIR_EXCLUDES(...) MIDAIR_THREADS(locks_excluded(__VA_ARGS__))
/// A function that the analysis can't follow; a comment beside it explains why it is correct.
#define MIDAIR_NO_THREAD_ANALYSIS MIDAIR_THREADS(no_thread_safety_analysis)

namespace midair::base
{

/// std::mutex, known to clang's analysis.
class MIDAIR_THREADS(capability("mutex")) Mutex
{
public:
    void lock() MIDAIR_THREADS(acquire_capability()) { _mutex.lock(); }
    void unlock() MIDAIR_THREADS(release_capability()) { _mutex.unlock(); }
    bool try_lock() MIDAIR_THREADS(try_acquire_capability(true)) { return _mutex.try_lock(); }

private:
    friend class Lock;
    std::mutex _mutex;
};

/// Holds a mutex until it goes out of scope, or until unlock(); lock() takes it again.
class MIDAIR_THREADS(scoped_lockable) Lock
{
public:
    explicit Lock(Mutex& mutex) MIDAIR_THREADS(acquire_capability(mutex)) : _lock(mutex._mutex) {}
    ~Lock() MIDAIR_THREADS(release_capability()) {}
    Lock(const Lock&) = delete;
    Lock& operator=(const Lock&) = delete;
    void lock() MIDAIR_THREADS(acquire_capability()) { _lock.lock(); }
    void unlock() MIDAIR_THREADS(release_capability()) { _lock.unlock(); }

private:
    friend class Condition;
    std::unique_lock<std::mutex> _lock;
};

/// Releases a held mutex and locks it again at the end of its scope.
class MIDAIR_THREADS(scoped_lockable) Unlocked
{
public:
    explicit Unlocked(Mutex& mutex) MIDAIR_THREADS(release_capability(mutex)) : _mutex(mutex)
    {
        _mutex.unlock();
    }
    ~Unlocked() MIDAIR_THREADS(release_capability()) { _mutex.lock(); }
    Unlocked(const Unlocked&) = delete;
    Unlocked& operator=(const Unlocked&) = delete;

private:
    Mutex& _mutex;
};

/// std::condition_variable on a Lock. It may wake spuriously, so each wait needs a loop that checks
/// its condition: in a loop clang sees that the lock is held, in a predicate it would not.
class Condition
{
public:
    void notifyOne() { _condition.notify_one(); }
    void notifyAll() { _condition.notify_all(); }
    void wait(Lock& lock) { _condition.wait(lock._lock); }
    /// @return false if `duration` has passed
    template<typename Duration>
    bool waitFor(Lock& lock, Duration duration)
    {
        return _condition.wait_for(lock._lock, duration) == std::cv_status::no_timeout;
    }
    /// The same until steadySeconds() is `time_s`; times beyond 30 years count as 30 years.
    bool waitUntil_s(Lock& lock, double time_s)
    {
        using Clock = std::chrono::steady_clock;
        const std::chrono::duration<double> since(std::min(time_s, 1e9));
        return waitUntil(lock,
                         Clock::time_point(std::chrono::duration_cast<Clock::duration>(since)));
    }
    /// @return false if `time` has passed
    template<typename Time>
    bool waitUntil(Lock& lock, Time time)
    {
        return _condition.wait_until(lock._lock, time) == std::cv_status::no_timeout;
    }

private:
    std::condition_variable _condition;
};

} // namespace midair::base
