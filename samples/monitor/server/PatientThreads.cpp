#include "samples/monitor/server/PatientThreads.h"

#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <exception>
#include <mutex>
#include <utility>

namespace midair::samples
{

struct PatientThreads::Count
{
    std::mutex mutex;
    std::condition_variable changed;
    int running = 0;
};

PatientThreads::PatientThreads() : _running(std::make_shared<Count>()) {}

PatientThreads::~PatientThreads()
{
    finish(0.0);
}

void PatientThreads::start(const char* name, std::function<void()> body)
{
    {
        const std::lock_guard<std::mutex> lock(_running->mutex);
        ++_running->running;
    }
    // Signals are for the program's own threads, but those of a crash, upon which it may silence
    // the array.
    sigset_t all;
    sigset_t before;
    ::sigfillset(&all);
    for (const int crash : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP})
        ::sigdelset(&all, crash);
    ::pthread_sigmask(SIG_SETMASK, &all, &before);
    _threads.emplace_back(
        [name, body = std::move(body), running = _running]() mutable
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
            const std::lock_guard<std::mutex> lock(running->mutex);
            --running->running;
            running->changed.notify_all();
        });
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

bool PatientThreads::finish(double atMost_s)
{
    bool areAllDone = false;
    {
        std::unique_lock<std::mutex> lock(_running->mutex);
        areAllDone = _running->changed.wait_for(lock,
                                                std::chrono::duration<double>(atMost_s),
                                                [this] { return _running->running == 0; });
    }
    for (std::thread& thread : _threads)
        if (areAllDone)
            thread.join();
        else
            thread.detach();
    _threads.clear();
    return areAllDone;
}

} // namespace midair::samples
