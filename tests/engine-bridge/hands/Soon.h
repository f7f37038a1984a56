#pragma once

#include <chrono>
#include <thread>

namespace midair::bridge
{

/// Waits until \a condition is true, for 10 s at most.
template<typename Condition>
bool soon(Condition condition)
{
    for (int i = 0; i < 2000; ++i)
    {
        if (condition()) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
}

} // namespace midair::bridge
