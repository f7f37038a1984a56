// Ctrl-C while a field is solved.
#include "engine-bridge/python/Bindings.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include <unistd.h>

namespace midair::python
{

namespace
{

/// A thread that solves for Python's main one, which alone sees signals, and
/// looks for them meanwhile. It is kept from solve to solve.
struct Worker
{
    const pid_t process = ::getpid(); ///< in the child of a fork there is no such thread
    std::mutex mutex;
    std::condition_variable changes;
    std::function<void()> task; ///< is run until it is empty again
    bool isLast = false;        ///< nobody waits for the task, and there won't be another
};

/// Workers that nobody waits for.
struct Abandoned
{
    std::mutex mutex;
    std::condition_variable changes;
    int number = 0;
};

Abandoned& abandoned()
{
    static auto* const all = new Abandoned;
    return *all;
}

void work(const std::shared_ptr<Worker>& own)
{
    std::unique_lock<std::mutex> lock(own->mutex);
    do
    {
        own->changes.wait(lock, [&] { return own->task != nullptr; });
        lock.unlock();
        own->task();
        lock.lock();
        own->task = nullptr;
        own->changes.notify_all();
    } while (!own->isLast);
    lock.unlock();
    Abandoned& all = abandoned();
    const std::lock_guard<std::mutex> counting(all.mutex);
    --all.number;
    all.changes.notify_all();
}

/// The worker of the main thread; guarded by Python's lock. Never let go by
/// itself, as the memory of one that a fork has left behind can't be.
std::shared_ptr<Worker>& kept()
{
    static auto* all = new std::shared_ptr<Worker>;
    if (*all && (*all)->process != ::getpid()) all = new std::shared_ptr<Worker>;
    return *all;
}

/// Takes the worker that is kept, so that a signal's handler that solves gets
/// another one.
std::shared_ptr<Worker> takeWorker()
{
    if (std::shared_ptr<Worker> worker = std::move(kept())) return worker;
    auto worker = std::make_shared<Worker>();
    std::thread([worker] { work(worker); }).detach();
    return worker;
}

/// Nobody waits for the worker's task any more. A solve that doesn't look
/// whether it's stopped for a while goes on meanwhile, and its field is let go.
void abandon(Worker& worker)
{
    const std::lock_guard<std::mutex> counting(abandoned().mutex);
    const std::lock_guard<std::mutex> lock(worker.mutex);
    ++abandoned().number;
    worker.isLast = true;
    if (worker.task == nullptr) worker.task = [] {}; // it has just ended
    worker.changes.notify_all();
}

/// Waits for a moment; true: the task has ended.
bool ends(Worker& worker)
{
    const py::gil_scoped_release released;
    std::unique_lock<std::mutex> lock(worker.mutex);
    return worker.changes.wait_for(
        lock, std::chrono::milliseconds(20), [&] { return worker.task == nullptr; });
}

/// Signals are seen on this thread alone.
bool isMainThread()
{
    const py::object thread = py::module_::import("threading").attr("main_thread")();
    return thread.attr("ident").cast<unsigned long>() == PyThread_get_thread_ident();
}

} // namespace

Outcome interruptible(const std::function<midair_status()>& call,
                      const std::function<void()>& cancel)
{
    const auto outcome = std::make_shared<Outcome>();
    const auto run = [call, outcome]
    {
        outcome->status = call();
        outcome->why = midair_last_error();
    };
    if (!isMainThread())
    {
        const py::gil_scoped_release released;
        run();
        return *outcome;
    }
    const std::shared_ptr<Worker> worker = takeWorker();
    {
        const std::lock_guard<std::mutex> lock(worker->mutex);
        worker->task = run;
        worker->changes.notify_all();
    }
    while (!ends(*worker))
    {
        if (PyErr_CheckSignals() == 0) continue;
        const py::error_already_set raised;
        // The solve may have been about to begin, and a solver in Python may not
        // look.
        for (int again = 0; again < 3; ++again)
        {
            cancel();
            interruptCancelled();
            if (ends(*worker)) break;
        }
        abandon(*worker);
        throw py::error_already_set(raised);
    }
    kept() = worker;
    return *outcome;
}

void awaitAbandoned()
{
    const py::gil_scoped_release released;
    Abandoned& all = abandoned();
    std::unique_lock<std::mutex> lock(all.mutex);
    all.changes.wait_for(lock, std::chrono::seconds(5), [&] { return all.number == 0; });
}

} // namespace midair::python
