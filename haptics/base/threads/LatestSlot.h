#pragma once

#include "haptics/base/threads/Mutex.h"

#include <chrono>
#include <cstdint>
#include <utility>

namespace midair::base
{

/// Slot that hands values from one thread to another. It holds one value; a newer value replaces an
/// older one, which is dropped and counted.
///
/// put() and take() swap their argument with the slot's value under a lock held only for the swap,
/// so neither side waits for the other's work, and buffers are reused without allocation. For one
/// producer and one consumer. close() wakes the consumer, which then gets CLOSED; a pending value
/// is dropped.
template<typename T>
class LatestSlot
{
public:
    /// Puts \a value into the slot and returns an old value (dropped or consumed) in it, whose
    /// memory the producer may reuse. Returns false, with \a value unchanged, if the slot is
    /// closed.
    bool put(T& value)
    {
        return put(value, [] {});
    }
    /// As above, and calls \a meanwhile() under the lock before the value can be taken; keep it
    /// short.
    template<typename Meanwhile>
    bool put(T& value, const Meanwhile& meanwhile)
    {
        {
            const Lock lock(_mutex);
            if (_closed) return false;
            std::swap(_value, value);
            ++_puts;
            if (_full) ++_drops;
            _full = true;
            meanwhile();
        }
        _filled.notifyOne();
        return true;
    }

    enum class Taken
    {
        VALUE,
        NOTHING, ///< no value came in time
        CLOSED
    };

    /// Wakes the present or next take(), which then returns NOTHING unless there is a value.
    void wake()
    {
        {
            const Lock lock(_mutex);
            _woken = true;
        }
        _filled.notifyOne();
    }

    /// Waits at most \a atMost_s for a value and swaps it into \a value.
    Taken take(T& value, double atMost_s)
    {
        return take(value, atMost_s, [] {});
    }
    /// As above, and calls \a meanwhile() after taking a value, before the next can be put.
    template<typename Meanwhile>
    Taken take(T& value, double atMost_s, const Meanwhile& meanwhile)
    {
        Lock lock(_mutex);
        using Clock = std::chrono::steady_clock;
        const auto end = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                            std::chrono::duration<double>(atMost_s));
        while (!_full && !_closed && !_woken && _filled.waitUntil(lock, end))
        {
        }
        _woken = false;
        if (_closed) return Taken::CLOSED;
        if (!_full) return Taken::NOTHING;
        std::swap(_value, value);
        _full = false;
        meanwhile();
        return Taken::VALUE;
    }

    void close()
    {
        close([] {});
    }
    template<typename Meanwhile>
    void close(const Meanwhile& meanwhile)
    {
        {
            const Lock lock(_mutex);
            _closed = true;
            meanwhile();
        }
        _filled.notifyAll();
    }

    /// Calls \a meanwhile(true if a value waits, true if closed) while the slot is locked.
    template<typename Meanwhile>
    void between(const Meanwhile& meanwhile)
    {
        const Lock lock(_mutex);
        meanwhile(_full, _closed);
    }

    /// Returns true if a value waits.
    bool isFull() const
    {
        const Lock lock(_mutex);
        return _full;
    }

    std::uint64_t puts() const
    {
        const Lock lock(_mutex);
        return _puts;
    }
    std::uint64_t drops() const
    {
        const Lock lock(_mutex);
        return _drops;
    }

private:
    mutable Mutex _mutex;
    Condition _filled;
    T _value MIDAIR_GUARDED_BY(_mutex){};
    bool _full MIDAIR_GUARDED_BY(_mutex) = false;
    bool _closed MIDAIR_GUARDED_BY(_mutex) = false;
    bool _woken MIDAIR_GUARDED_BY(_mutex) = false;
    std::uint64_t _puts MIDAIR_GUARDED_BY(_mutex) = 0;
    std::uint64_t _drops MIDAIR_GUARDED_BY(_mutex) = 0;
};

} // namespace midair::base
