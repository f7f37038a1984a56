#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <utility>

namespace midair::base
{

/// Hand-off between two threads, one deep: the newest value wins, older ones are dropped and
/// counted.
///
/// put() and take() swap their argument with the slot's under a lock that is never held for longer
/// than a swap: neither side waits for the other's work, and memory goes round between the two
/// without being allocated anew. One producer, one consumer. close() wakes the consumer, which is
/// then told CLOSED; what was not taken by then is dropped.
template<typename T>
class LatestSlot
{
public:
    /// Leaves in \a value a used one (dropped or consumed earlier), whose memory the producer may
    /// refill. False, with \a value untouched, when closed.
    bool put(T& value)
    {
        return put(value, [] {});
    }
    /// Calls \a meanwhile() once the value is there, before anybody can take it: it should be
    /// short.
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
        NOTHING, ///< none came in time
        CLOSED
    };

    /// Waits for a value, \a atMost_s at most, and swaps it into \a value.
    Taken take(T& value, double atMost_s)
    {
        return take(value, atMost_s, [] {});
    }
    /// Calls \a meanwhile() when it takes a value, before the next can be put.
    template<typename Meanwhile>
    Taken take(T& value, double atMost_s, const Meanwhile& meanwhile)
    {
        std::unique_lock<std::mutex> lock(_mutex);
        _filled.wait_for(
            lock, std::chrono::duration<double>(atMost_s), [this] { return _full || _closed; });
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

    /// Calls \a meanwhile(whether a value waits, whether closed) while nothing is put or taken.
    template<typename Meanwhile>
    void between(const Meanwhile& meanwhile)
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        meanwhile(_full, _closed);
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
    std::uint64_t _puts = 0;
    std::uint64_t _drops = 0;
};

} // namespace midair::base
