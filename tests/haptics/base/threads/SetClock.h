#pragma once

#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <mutex>
#include <stdexcept>

namespace midair::test
{

/// A clock that stands still until a test lets time pass. Who waits for it is woken at the time
/// that is due, and has done its work before time goes on: what a test sees then doesn't depend on
/// the machine. Whatever waits for it has to live as long as time passes.
class SetClock : public base::Clock
{
public:
    explicit SetClock(double now_s = 1000.0) : _now_s(now_s) {}

    double now_s() const override { return _now_s; }
    void wait(base::Condition& condition, base::Lock& lock, double until_s) const override
    {
        {
            const std::lock_guard<std::mutex> noting(_mutex);
            if (until_s <= _now_s) return;
            _waiting[&condition] = {until_s, _round};
        }
        _begun.notify_all();
        condition.waitFor(lock, std::chrono::milliseconds(1)); // where the word came too early
    }

    /// Waits until \a count threads wait; for threads that have just been started.
    void await(std::size_t count) const
    {
        std::unique_lock<std::mutex> lock(_mutex);
        waitUntil(lock, [&] { return _waiting.size() >= count; });
    }

    void pass(double duration_s)
    {
        const double end_s = _now_s + duration_s;
        for (double due_s = settle(); due_s <= end_s; due_s = settle())
            _now_s = due_s;
        _now_s = end_s;
        settle();
    }

    /// Time passes while those who could wait for it are at work. For what they call.
    void jump(double duration_s) { _now_s = _now_s + duration_s; }

private:
    struct Waiting
    {
        double until_s = 0.0;
        std::uint64_t round = 0;
    };

    /// Waits until all wait for what is to come, and know all that was done before. Returns the
    /// time that is due next.
    double settle()
    {
        std::unique_lock<std::mutex> lock(_mutex);
        ++_round;
        for (const auto& one : _waiting)
            one.first->notifyAll();
        double next_s = 0.0;
        const auto isSettled = [&]
        {
            next_s = std::numeric_limits<double>::infinity();
            bool all = true;
            for (const auto& [condition, one] : _waiting)
            {
                all = all && one.round == _round && one.until_s > _now_s;
                next_s = std::min(next_s, one.until_s);
            }
            return all;
        };
        waitUntil(lock, isSettled);
        return next_s;
    }
    template<typename Condition>
    void waitUntil(std::unique_lock<std::mutex>& lock, const Condition& condition) const
    {
        constexpr std::chrono::seconds kPatience(60); // only stops a test that fails
        if (!_begun.wait_for(lock, kPatience, condition))
            throw std::runtime_error("who waits for the clock doesn't come back");
    }

    std::atomic<double> _now_s;
    mutable std::mutex _mutex; ///< guards what follows
    mutable std::condition_variable _begun;
    mutable std::map<base::Condition*, Waiting> _waiting;
    std::uint64_t _round = 0;
};

} // namespace midair::test
