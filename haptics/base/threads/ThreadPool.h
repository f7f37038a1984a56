#pragma once

#include "haptics/base/threads/Mutex.h"

#include <atomic>
#include <thread>
#include <type_traits>
#include <vector>

namespace midair::base
{

/// Returns the number of cores available to this process, at least 1. More threads would only wait
/// for each other.
int coreCount();

/// Pool of threads that run one function together; the caller waits until all are done. A call
/// doesn't allocate and costs a few microseconds, because idle workers spin briefly before they
/// sleep. If there are more threads than cores they sleep at once.
class ThreadPool
{
public:
    /// \a threads: number of threads including the caller, >= 1.
    explicit ThreadPool(int threads);
    ~ThreadPool();
    ThreadPool(const ThreadPool&) = delete;
    ThreadPool& operator=(const ThreadPool&) = delete;

    int threads() const { return static_cast<int>(_workers.size()) + 1; }

    /// Calls task(thread) for thread = 0 .. threads() - 1, each on its own thread, and returns when
    /// all are done. Tasks must not throw. Only one run at a time.
    template<typename Task>
    void run(Task&& task)
    {
        using Plain = std::remove_reference_t<Task>;
        runErased([](void* data, int thread) { (*static_cast<Plain*>(data))(thread); }, &task);
    }

    /// Calls task(0) on this thread and task(thread) on workers that are awake before it finishes;
    /// returns when all of these are done. A worker may be called twice. For work that threads
    /// share dynamically: a sleeping worker takes about 50 microseconds to wake up, and is not
    /// waited for.
    template<typename Task>
    void runHelped(Task&& task)
    {
        using Plain = std::remove_reference_t<Task>;
        runErasedHelped([](void* data, int thread) { (*static_cast<Plain*>(data))(thread); },
                        &task);
    }
    /// Wakes sleeping workers ahead of run(), which takes about 50 microseconds; the caller may
    /// prepare work meanwhile. Costs about a microsecond.
    void wake();

private:
    using Function = void (*)(void*, int);
    /// Added to _inside while no worker may enter.
    static constexpr int kClosed = -(1 << 30);

    void runErased(Function function, void* data);
    void runErasedHelped(Function function, void* data);
    void begin(Function function, void* data, bool isHelped);
    void work(int thread);
    unsigned help(int thread, unsigned generation);
    unsigned waitForWork(unsigned seen);
    template<typename IsDone>
    void waitUntil(const IsDone& isDone);
    void tellCaller();

    const int _spins; ///< checks before a thread sleeps

    std::vector<std::thread> _workers;
    Mutex _mutex;
    Condition _wake; ///< workers wait for work
    Condition _done; ///< the caller waits for workers
    std::atomic<bool> _callerSleeps{false};
    std::atomic<unsigned> _generation{0}; ///< of runs; odd: a run that workers may help
    std::atomic<int> _running{0};         ///< workers that the caller waits for
    std::atomic<int> _inside{kClosed};    ///< workers that help
    std::atomic<bool> _stop{false};
    unsigned _calls MIDAIR_GUARDED_BY(_mutex) = 0; ///< calls of wake()
    // Written before a generation begins and read only by its threads, so the generation orders
    // them.
    Function _function = nullptr;
    void* _data = nullptr;
};

} // namespace midair::base
