#pragma once

#include <atomic>
#include <memory>
#include <stdexcept>
#include <utility>

namespace midair::base
{

/// Thrown by work that was asked to stop and has no report to return this in.
class Stopped : public std::runtime_error
{
public:
    Stopped() : std::runtime_error("stopped before it was done") {}
};

/// Tells work whether it was asked to stop. Copies share a StopSource; a token without a source
/// never requests a stop.
class StopToken
{
public:
    StopToken() = default;

    /// Returns true if a stop was requested. Costs one relaxed load; for loops whose iterations
    /// take a microsecond or more. Any thread.
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

/// Checks a token once per number of iterations, for loops whose iterations are much shorter than a
/// check.
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

/// Asks work that holds its tokens to stop. Any thread. A request stays until clear(), which the
/// thread that runs the work may call between two pieces of work: work that has begun to stop
/// relies on the request.
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
