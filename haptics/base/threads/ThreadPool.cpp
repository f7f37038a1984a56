#include "haptics/base/threads/ThreadPool.h"

#include "haptics/base/threads/Mutex.h"

#include <algorithm>

namespace midair::base
{

namespace
{

// About 20 to 50 microseconds: longer than the pause between two passes of one solve and between
// wake() and the first, shorter than that between frames.
constexpr int kSpins = 2000;

void pause()
{
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#else
    std::this_thread::yield();
#endif
}

} // namespace

int coreCount()
{
    return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

// With more threads than cores, a worker that spins takes a core from other threads.
ThreadPool::ThreadPool(int threads) : _spins(threads <= coreCount() ? kSpins : 0)
{
    for (int thread = 1; thread < threads; ++thread)
        _workers.emplace_back([this, thread] { work(thread); });
}

ThreadPool::~ThreadPool()
{
    {
        const Lock lock(_mutex);
        _stop = true;
        _generation += 2;
    }
    _wake.notifyAll();
    for (std::thread& worker : _workers)
        worker.join();
}

void ThreadPool::begin(Function function, void* data, bool isHelped)
{
    {
        const Lock lock(_mutex);
        _function = function;
        _data = data;
        const unsigned even = _generation & ~1U;
        if (isHelped)
            _inside = 0;
        else
            _running = static_cast<int>(_workers.size());
        _generation = even + (isHelped ? 3 : 2);
    }
    _wake.notifyAll();
}

void ThreadPool::runErased(Function function, void* data)
{
    if (_workers.empty()) return function(data, 0);
    begin(function, data, false);
    function(data, 0);
    waitUntil([this] { return _running == 0; });
}

void ThreadPool::runErasedHelped(Function function, void* data)
{
    if (_workers.empty()) return function(data, 0);
    begin(function, data, true);
    function(data, 0);
    _inside += kClosed;
    waitUntil([this] { return _inside == kClosed; });
}

void ThreadPool::wake()
{
    if (_workers.empty() || _spins == 0) return;
    {
        const Lock lock(_mutex);
        ++_calls;
    }
    _wake.notifyAll();
}

// Spins first, because the other threads have equal work and finish at about the same time, unless
// there are too few cores.
template<typename IsDone>
void ThreadPool::waitUntil(const IsDone& isDone)
{
    for (int spins = 0; spins < _spins; ++spins)
    {
        if (isDone()) return;
        pause();
    }
    Lock lock(_mutex);
    _callerSleeps = true;
    while (!isDone())
        _done.wait(lock);
    _callerSleeps = false;
}

// Sequentially consistent, like the caller's store and load: one of the two threads sees the
// other's write.
void ThreadPool::tellCaller()
{
    if (!_callerSleeps) return;
    const Lock lock(_mutex);
    _done.notifyOne();
}

// Enters the open run, which may be a later one than \a generation; returns its number. The caller
// starts no other run while somebody is inside.
unsigned ThreadPool::help(int thread, unsigned generation)
{
    int inside = _inside;
    while (inside >= 0)
    {
        if (!_inside.compare_exchange_weak(inside, inside + 1)) continue;
        generation = _generation;
        _function(_data, thread);
        if (--_inside == kClosed) tellCaller();
        break;
    }
    return generation;
}

unsigned ThreadPool::waitForWork(unsigned seen)
{
    for (int spins = 0; spins < _spins; ++spins)
    {
        const unsigned generation = _generation.load(std::memory_order_acquire);
        if (generation != seen) return generation;
        pause();
    }
    Lock lock(_mutex);
    const unsigned calls = _calls;
    while (_calls == calls && _generation.load(std::memory_order_relaxed) == seen)
        _wake.wait(lock);
    return _generation.load(std::memory_order_relaxed);
}

void ThreadPool::work(int thread)
{
    unsigned seen = 0;
    for (;;)
    {
        const unsigned generation = waitForWork(seen);
        if (_stop) return;
        if (generation == seen) continue; // woken for work that is about to come
        if (generation % 2 == 1)
        {
            seen = help(thread, generation);
            continue;
        }
        seen = generation;
        _function(_data, thread);
        if (--_running == 0) tellCaller();
    }
}

} // namespace midair::base
