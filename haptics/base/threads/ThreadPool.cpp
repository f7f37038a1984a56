#include "haptics/base/threads/ThreadPool.h"

#include <algorithm>

namespace midair::base
{

namespace
{

// About 20 to 50 microseconds: longer than the pause between two passes of one solve, shorter than
// that between frames.
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
        const std::lock_guard<std::mutex> lock(_mutex);
        _stop = true;
        ++_generation;
    }
    _wake.notify_all();
    for (std::thread& worker : _workers)
        worker.join();
}

void ThreadPool::runErased(Function function, void* data)
{
    if (_workers.empty())
    {
        function(data, 0);
        return;
    }
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _function = function;
        _data = data;
        _running = static_cast<int>(_workers.size());
        ++_generation;
    }
    _wake.notify_all();
    function(data, 0);
    waitForOthers();
}

// Spins first: the others have as much work and finish at about the same time, unless there are too
// few cores.
void ThreadPool::waitForOthers()
{
    for (int spins = 0; spins < _spins; ++spins)
    {
        if (_running.load(std::memory_order_acquire) == 0) return;
        pause();
    }
    std::unique_lock<std::mutex> lock(_mutex);
    _callerSleeps = true;
    _done.wait(lock, [this] { return _running == 0; });
    _callerSleeps = false;
}

unsigned ThreadPool::waitForWork(unsigned seen)
{
    for (int spins = 0; spins < _spins; ++spins)
    {
        const unsigned generation = _generation.load(std::memory_order_acquire);
        if (generation != seen) return generation;
        pause();
    }
    std::unique_lock<std::mutex> lock(_mutex);
    _wake.wait(lock, [&] { return _generation.load(std::memory_order_relaxed) != seen; });
    return _generation.load(std::memory_order_relaxed);
}

void ThreadPool::work(int thread)
{
    unsigned seen = 0;
    for (;;)
    {
        seen = waitForWork(seen);
        if (_stop) return;
        _function(_data, thread);
        // Sequentially consistent, as the caller's store and load are: one of the two threads sees
        // what the other wrote.
        if (_running.fetch_sub(1) > 1 || !_callerSleeps) continue;
        const std::lock_guard<std::mutex> lock(_mutex);
        _done.notify_one();
    }
}

} // namespace midair::base
