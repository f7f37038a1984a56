#include "samples/shared/views/Signals.h"

#include "haptics/base/threads/Mutex.h"

#include <cerrno>
#include <chrono>
#include <csignal>
#include <mutex>
#include <utility>

#include <semaphore.h>
#include <unistd.h>

namespace midair::samples
{

namespace
{

using namespace std::chrono_literals;

// From the signal on; the end within 2 s, with time to be scheduled.
constexpr auto kSilence = 1000ms; // a frame may take as long
constexpr auto kEnd = 1700ms;
constexpr auto kFarewell = 10s; // of a program that has heard of the signal
constexpr auto kLook = 20ms;

std::atomic<int> stopSignal{0}; // the first that came; 0: none yet
static_assert(std::atomic<int>::is_always_lock_free, "a handler may not wait for a lock");
std::atomic<bool> isStopHeard{false};

sem_t stopWakes;
const bool kCanWatchStops = ::sem_init(&stopWakes, 0, 0) == 0;

extern "C" void askToStop(int number)
{
    const int before = errno;
    int none = 0;
    if (stopSignal.compare_exchange_strong(none, number)) ::sem_post(&stopWakes);
    errno = before;
}

/// What a SilenceAtStop wants called, each on a thread of its own.
struct Wanted
{
    base::Mutex mutex; ///< held while it is called
    std::function<void()> call MIDAIR_GUARDED_BY(mutex);

    void set(std::function<void()> next)
    {
        const base::Lock lock(mutex);
        call = std::move(next);
    }
    void callByThread()
    {
        std::thread(
            [this]
            {
                const base::Lock lock(mutex);
                if (call) call();
            })
            .detach();
    }
};

/// Two, so that silence waits for no disk. Never destroyed, as the threads outlive static objects.
struct Silencing
{
    Wanted silence;
    Wanted asked;
};

Silencing& silencing()
{
    static auto* const all = new Silencing;
    return *all;
}

/// Returns true if the program has heard of the signal until \a end.
bool isHeardUntil(std::chrono::steady_clock::time_point end)
{
    while (!isStopHeard && std::chrono::steady_clock::now() < end)
        std::this_thread::sleep_for(kLook);
    return isStopHeard;
}

void watchStops()
{
    while (::sem_wait(&stopWakes) != 0 && errno == EINTR)
    {
    }
    const auto begin = std::chrono::steady_clock::now();
    silencing().asked.callByThread();
    if (!isHeardUntil(begin + kSilence)) silencing().silence.callByThread();
    if (isHeardUntil(begin + kEnd))
    {
        std::this_thread::sleep_until(begin + kFarewell - (kEnd - kSilence));
        silencing().silence.callByThread();
        std::this_thread::sleep_until(begin + kFarewell);
    }
    // As the signal would have ended it; what guards devices silences them once the program is
    // dead.
    std::signal(stopSignal, SIG_DFL);
    ::kill(::getpid(), stopSignal);
}

std::atomic<int> newestSignal{0}; // 0: none since it was followed
static_assert(std::atomic<int>::is_always_lock_free, "a handler may not wait for a lock");

sem_t wakes;
const bool kCanWake = ::sem_init(&wakes, 0, 0) == 0;

extern "C" void noteMuteSignal(int number)
{
    const int before = errno;
    newestSignal = number;
    ::sem_post(&wakes);
    errno = before;
}

} // namespace

void catchStopSignals()
{
    struct sigaction action = {};
    action.sa_handler = askToStop;
    action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
    sigemptyset(&action.sa_mask);
    struct sigaction before = {};
    for (const int number : {SIGINT, SIGTERM, SIGHUP})
        if (number != SIGHUP || ::sigaction(number, nullptr, &before) != 0 ||
            before.sa_handler != SIG_IGN)
            ::sigaction(number, &action, nullptr);
    static std::once_flag once;
    std::call_once(once,
                   []
                   {
                       silencing();
                       if (kCanWatchStops) std::thread(watchStops).detach();
                   });
}

bool isStopAsked()
{
    if (stopSignal == 0) return false;
    isStopHeard = true;
    return true;
}

SilenceAtStop::SilenceAtStop(std::function<void()> silence, std::function<void()> asked)
{
    silencing().silence.set(std::move(silence));
    silencing().asked.set(std::move(asked));
}

SilenceAtStop::~SilenceAtStop()
{
    silencing().silence.set(nullptr);
    silencing().asked.set(nullptr);
}

void catchMuteSignals()
{
    struct sigaction action = {};
    action.sa_handler = noteMuteSignal;
    action.sa_flags = SA_RESTART;
    sigemptyset(&action.sa_mask);
    for (const int number : {SIGUSR1, SIGUSR2})
        sigaction(number, &action, nullptr);
}

MuteSignals::MuteSignals(std::function<void(bool)> follow, std::function<void()> keep) :
    _follow(std::move(follow)),
    _keep(std::move(keep))
{
    if (kCanWake) _thread = std::thread([this] { run(); });
}

MuteSignals::~MuteSignals()
{
    end();
}

void MuteSignals::wake()
{
    _isAsked = true;
    ::sem_post(&wakes);
}

void MuteSignals::end()
{
    if (!_thread.joinable()) return;
    _isEnding = true;
    ::sem_post(&wakes);
    _thread.join();
}

void MuteSignals::run()
{
    for (;;)
    {
        const bool isLast = _isEnding; // read before the signal, which so is followed still
        const int number = newestSignal.exchange(0);
        if (number != 0) _follow(number == SIGUSR1);
        if ((_isAsked.exchange(false) || number != 0) && _keep) _keep();
        if (isLast) return;
        while (::sem_wait(&wakes) != 0 && errno == EINTR)
        {
        }
    }
}

} // namespace midair::samples
