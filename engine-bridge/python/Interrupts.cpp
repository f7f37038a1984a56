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

/// A thread that solves for Python's main thread, which meanwhile checks for signals (only the main
/// thread gets them). It is kept from solve to solve.
struct Worker
{
    const pid_t process = ::getpid(); ///< the child of a fork has no such thread
    std::mutex mutex;
    std::condition_variable changes;
    std::function<void()> task; ///< runs until it is empty again
    bool isLast = false;        ///< the task is abandoned, and no other follows
};

/// Abandoned workers.
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

/// The worker of the main thread; guarded by the GIL. Never freed, because the memory of a worker
/// left behind by a fork can't be.
std::shared_ptr<Worker>& kept()
{
    static auto* all = new std::shared_ptr<Worker>;
    if (*all && (*all)->process != ::getpid()) all = new std::shared_ptr<Worker>;
    return *all;
}

/// Takes the kept worker, so that a signal handler that solves gets another one.
std::shared_ptr<Worker> takeWorker()
{
    if (std::shared_ptr<Worker> worker = std::move(kept())) return worker;
    auto worker = std::make_shared<Worker>();
    std::thread([worker] { work(worker); }).detach();
    return worker;
}

/// Abandons the worker's task. A solve that rarely checks for a stop may continue for a while; its
/// field is dropped.
void abandon(Worker& worker)
{
    const std::lock_guard<std::mutex> counting(abandoned().mutex);
    const std::lock_guard<std::mutex> lock(worker.mutex);
    ++abandoned().number;
    worker.isLast = true;
    if (worker.task == nullptr) worker.task = [] {}; // it has just ended
    worker.changes.notify_all();
}

/// Waits for a moment; returns true if the task has ended.
bool ends(Worker& worker)
{
    const py::gil_scoped_release released;
    std::unique_lock<std::mutex> lock(worker.mutex);
    return worker.changes.wait_for(
        lock, std::chrono::milliseconds(20), [&] { return worker.task == nullptr; });
}

/// Only this thread gets signals.
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
        // The solve may just have been starting, and a Python solver may not check.
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
