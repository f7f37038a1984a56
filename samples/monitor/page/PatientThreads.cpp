#include "samples/monitor/page/PatientThreads.h"

#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

namespace midair::samples
{

namespace
{

/// While it lives, threads that start are sent no signals, which are for the program's own threads,
/// but those of a crash, upon which it may silence the array.
class MaskedSignals
{
public:
    MaskedSignals()
    {
        sigset_t all;
        ::sigfillset(&all);
        for (const int crash : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP})
            ::sigdelset(&all, crash);
        ::pthread_sigmask(SIG_SETMASK, &all, &_before);
    }
    ~MaskedSignals() { ::pthread_sigmask(SIG_SETMASK, &_before, nullptr); }
    MaskedSignals(const MaskedSignals&) = delete;
    MaskedSignals& operator=(const MaskedSignals&) = delete;

private:
    sigset_t _before{};
};

} // namespace

struct PatientThreads::Count
{
    std::mutex mutex;
    std::condition_variable changed;
    int running = 0;

    void add(int change)
    {
        const std::lock_guard<std::mutex> lock(mutex);
        running += change;
        changed.notify_all();
    }
};

PatientThreads::PatientThreads() : _running(std::make_shared<Count>()) {}

void PatientThreads::start(const char* name, std::function<void()> body)
{
    _running->add(1);
    const auto run = [name, body = std::move(body), running = _running]() mutable
    {
        try
        {
            body();
        }
        catch (const std::exception& error)
        {
            std::fprintf(stderr, "%s ended: %s\n", name, error.what());
        }
        body = nullptr; // what it holds is let go before anybody is told
        running->add(-1);
    };
    const MaskedSignals masked;
    try
    {
        std::thread(run).detach();
    }
    catch (...)
    {
        _running->add(-1);
        throw;
    }
}

bool PatientThreads::finish(double atMost_s)
{
    std::unique_lock<std::mutex> lock(_running->mutex);
    return _running->changed.wait_for(
        lock, std::chrono::duration<double>(atMost_s), [this] { return _running->running == 0; });
}

} // namespace midair::samples
