#pragma once

#include <atomic>
#include <memory>
#include <stdexcept>
#include <utility>

namespace midair::base
{

/// Thrown by work that was told to stop and has no report of its own to say so.
class Stopped : public std::runtime_error
{
public:
    Stopped() : std::runtime_error("stopped before it was done") {}
};

/// Tells work whether it is to be broken off; copies look at the same StopSource. One of no source
/// never asks for it.
class StopToken
{
public:
    StopToken() = default;

    /// One relaxed load, for every turn of a loop that takes a microsecond or more. Any thread.
    bool requested() const { return _flag && _flag->load(std::memory_order_relaxed); }
    void throwIfRequested() const
    {
        if (requested()) throw Stopped();
    }

private:
    friend class StopSource;
    explicit StopToken(std::shared_ptr<const std::atomic<bool>> flag) : _flag(std::move(flag)) {}

    std::shared_ptr<const std::atomic<bool>> _flag;
};

/// Looks at a token once in a number of turns: for loops whose turns are much shorter than a look.
class StopLook
{
public:
    explicit StopLook(const StopToken& token, unsigned everyTurns = 256) :
        _token(token),
        _everyTurns(everyTurns)
    {
    }
    void turn()
    {
        if (++_turns % _everyTurns == 0) _token.throwIfRequested();
    }

private:
    const StopToken& _token;
    const unsigned _everyTurns;
    unsigned _turns = 0;
};

/// Asks whoever holds its tokens to end. Any thread. What is asked for stands until clear(), which
/// belongs between two pieces of work, called by whoever runs them: work that began to stop relies
/// on the request staying.
class StopSource
{
public:
    StopSource() : _flag(std::make_shared<std::atomic<bool>>(false)) {}

    StopToken token() const { return StopToken(_flag); }
    void request() { _flag->store(true, std::memory_order_relaxed); }
    void clear() { _flag->store(false, std::memory_order_relaxed); }

private:
    std::shared_ptr<std::atomic<bool>> _flag;
};

} // namespace midair::base
