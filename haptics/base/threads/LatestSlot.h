#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <utility>

namespace midair::base
{

/// Slot that hands values from one thread to another. It holds one value: a newer one replaces it,
/// and the older one is dropped and counted.
///
/// put() and take() swap their argument with the slot's value under a lock that is held only for
/// the swap, so neither side waits for the other's work, and buffers are reused without allocation.
/// For one producer and one consumer. close() wakes the consumer, which then gets CLOSED; a value
/// that was not taken is dropped.
template<typename T>
class LatestSlot
{
public:
    /// Puts \a value into the slot and leaves an old one (dropped or consumed) in it, whose memory
    /// the producer may reuse. Returns false, with \a value unchanged, if the slot is closed.
    bool put(T& value)
    {
        return put(value, [] {});
    }
    /// As above, and calls \a meanwhile() under the lock, before the value can be taken; it should
    /// be short.
    template<typename Meanwhile>
    bool put(T& value, const Meanwhile& meanwhile)
    {
        {
            const std::lock_guard<std::mutex> lock(_mutex);
            if (_closed) return false;
            std::swap(_value, value);
            ++_puts;
            if (_full) ++_drops;
            _full = true;
            meanwhile();
        }
        _filled.notify_one();
        return true;
    }

    enum class Taken
    {
        VALUE,
        NOTHING, ///< no value came in time
        CLOSED
    };

    /// Ends the wait of take(), or of the next one, which then gets NOTHING unless there is a
    /// value.
    void wake()
    {
        {
            const std::lock_guard<std::mutex> lock(_mutex);
            _woken = true;
        }
        _filled.notify_one();
    }

    /// Waits for a value for at most \a atMost_s and swaps it into \a value.
    Taken take(T& value, double atMost_s)
    {
        return take(value, atMost_s, [] {});
    }
    /// As above, and calls \a meanwhile() when it takes a value, before the next can be put.
    template<typename Meanwhile>
    Taken take(T& value, double atMost_s, const Meanwhile& meanwhile)
    {
        std::unique_lock<std::mutex> lock(_mutex);
        _filled.wait_for(lock,
                         std::chrono::duration<double>(atMost_s),
                         [this] { return _full || _closed || _woken; });
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
            const std::lock_guard<std::mutex> lock(_mutex);
            _closed = true;
            meanwhile();
        }
        _filled.notify_all();
    }

    /// Calls \a meanwhile(true if a value waits, true if closed) while nothing can be put or taken.
    template<typename Meanwhile>
    void between(const Meanwhile& meanwhile)
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        meanwhile(_full, _closed);
    }

    /// Returns true if a value waits.
    bool isFull() const
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return _full;
    }

    std::uint64_t puts() const { return locked(_puts); }
    std::uint64_t drops() const { return locked(_drops); }

private:
    std::uint64_t locked(const std::uint64_t& counter) const
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return counter;
    }

    mutable std::mutex _mutex;
    std::condition_variable _filled;
    T _value{};
    bool _full = false;
    bool _closed = false;
    bool _woken = false;
    std::uint64_t _puts = 0;
    std::uint64_t _drops = 0;
};

} // namespace midair::base
