#pragma once

#include <chrono>
#include <functional>
#include <thread>

/// Whether \a condition comes true; the deadline only stops a test that fails.
inline bool eventually(const std::function<bool()>& condition, double seconds = 20)
{
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (!condition())
    {
        if (std::chrono::steady_clock::now() > end) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
}
