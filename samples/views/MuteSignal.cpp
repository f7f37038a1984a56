#include "samples/views/MuteSignal.h"

#include <cerrno>
#include <csignal>
#include <initializer_list>
#include <utility>

#include <semaphore.h>

namespace midair::samples
{

namespace
{

std::atomic<int> newestSignal{0}; // 0: none since it was followed
static_assert(std::atomic<int>::is_always_lock_free, "a handler may not wait for a lock");

sem_t wakes;
const bool isReady = ::sem_init(&wakes, 0, 0) == 0;

extern "C" void noteMuteSignal(int number)
{
    const int before = errno;
    newestSignal = number;
    ::sem_post(&wakes);
    errno = before;
}

} // namespace

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
    if (isReady) _thread = std::thread([this] { run(); });
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
