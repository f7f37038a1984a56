#include "samples/views/StopSignal.h"

#include <csignal>
#include <initializer_list>

namespace midair::samples
{

namespace
{

// All that a handler may safely touch.
volatile std::sig_atomic_t stopAsked = 0;

extern "C" void askToStop(int)
{
    stopAsked = 1;
}

} // namespace

void catchStopSignals()
{
    struct sigaction action = {};
    action.sa_handler = askToStop;
    action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
    sigemptyset(&action.sa_mask);
    for (const int number : {SIGINT, SIGTERM})
        sigaction(number, &action, nullptr);
}

bool isStopAsked()
{
    return stopAsked != 0;
}

} // namespace midair::samples
