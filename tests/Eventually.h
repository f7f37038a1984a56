#pragma once

#include <chrono>
#include <thread>

/// Lets \a seconds pass: for what nothing but the wall clock brings about, or would.
inline void letPass(double seconds)
{
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

/// Whether \a condition, which is asked each millisecond, comes true; the patience is more than a
/// busy machine uses up, and only ends a test that fails.
template<typename Condition>
bool eventually(Condition&& condition, double patience_s = 60.0)
{
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(patience_s);
    while (!condition())
    {
        if (std::chrono::steady_clock::now() > end) return false;
        letPass(1e-3);
    }
    return true;
}
