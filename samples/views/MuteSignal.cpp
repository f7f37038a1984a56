#include "samples/views/MuteSignal.h"

#include <atomic>
#include <csignal>
#include <initializer_list>

namespace midair::samples
{

namespace
{

std::atomic<int> newestSignal{0}; // 0: none since it was looked at
static_assert(std::atomic<int>::is_always_lock_free, "a handler may not wait for a lock");

extern "C" void noteMuteSignal(int number)
{
    newestSignal = number;
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

void followMuteSignals(osgMidair::HapticScene& scene)
{
    const int number = newestSignal.exchange(0);
    if (number != 0) scene.setMuted(number == SIGUSR1);
}

} // namespace midair::samples
