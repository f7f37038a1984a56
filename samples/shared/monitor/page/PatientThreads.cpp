#include "samples/shared/monitor/page/PatientThreads.h"

#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"

#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <thread>
#include <utility>

namespace midair::samples
{

struct PatientThreads::Count
{
    base::Mutex mutex;
    base::Condition changed;
    int running MIDAIR_GUARDED_BY(mutex) = 0;

    void add(int change)
    {
        const base::Lock lock(mutex);
        running += change;
        changed.notifyAll();
    }
};

PatientThreads::PatientThreads() : _running(std::make_shared<Count>()) {}

void PatientThreads::start(const char* name, std::function<void()> body)
{
    _running->add(1);
    auto run = [name, body = std::move(body), running = _running]() mutable
    {
        try
        {
            body();
        }
        catch (const std::exception& error)
        {
            std::fprintf(stderr, "%s ended: %s\n", name, error.what());
        }
        catch (...)
        {
            std::fprintf(stderr, "%s ended\n", name);
        }
        body = nullptr; // what it holds is let go before anybody is told
        running->add(-1);
    };
    // Signals are for the program's own threads, but those of a crash, upon which it may silence
    // the array.
    sigset_t all;
    sigset_t before;
    ::sigfillset(&all);
    for (const int crash : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP})
        ::sigdelset(&all, crash);
    ::pthread_sigmask(SIG_SETMASK, &all, &before);
    try
    {
        std::thread(std::move(run)).detach();
    }
    catch (...)
    {
        _running->add(-1);
        ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
        throw;
    }
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

bool PatientThreads::finish(double atMost_s)
{
    const double end_s = base::steadySeconds() + atMost_s;
    base::Lock lock(_running->mutex);
    while (_running->running != 0 && _running->changed.waitUntil_s(lock, end_s))
    {
    }
    return _running->running == 0;
}

} // namespace midair::samples
