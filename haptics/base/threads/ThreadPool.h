#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <type_traits>
#include <vector>

namespace midair::base
{

/// Returns the number of cores that this process may use, at least 1. More threads than that only
/// wait for one another.
int coreCount();

/// Pool of threads that run one function together; the caller waits until all are done. A call
/// allocates nothing and costs a few microseconds, since idle workers spin for a moment before they
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

private:
    using Function = void (*)(void*, int);
    void runErased(Function function, void* data);
    void work(int thread);
    unsigned waitForWork(unsigned seen);
    void waitForOthers();

    const int _spins; ///< checks before a thread sleeps

    std::vector<std::thread> _workers;
    std::mutex _mutex;
    std::condition_variable _wake; ///< workers wait for work
    std::condition_variable _done; ///< the caller waits for workers
    std::atomic<bool> _callerSleeps{false};
    std::atomic<unsigned> _generation{0};
    std::atomic<int> _running{0};
    std::atomic<bool> _stop{false};
    Function _function = nullptr;
    void* _data = nullptr;
};

} // namespace midair::base
