#include "samples/installations/shell/MuteSignal.h"

#include <atomic>
#include <csignal>
#include <initializer_list>

namespace midair::samples
{

namespace
{

std::atomic<MuteSignal> newestSignal{MuteSignal::NONE};
static_assert(std::atomic<MuteSignal>::is_always_lock_free, "a handler may not wait for a lock");

extern "C" void noteMuteSignal(int number)
{
    newestSignal = number == SIGUSR1 ? MuteSignal::MUTE : MuteSignal::PLAY;
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

MuteSignal takeMuteSignal()
{
    return newestSignal.exchange(MuteSignal::NONE);
}

} // namespace midair::samples
