#pragma once

#include "tests/device-usb/EmulatedArray.h"

#include <chrono>
#include <functional>
#include <thread>

/// Waits for what another thread brings about; generous since the machine may be busy, but a pass
/// takes as long as it takes.
inline bool eventually(const std::function<bool()>& condition, double seconds = 10)
{
    const double end_s = EmulatedArray::now_s() + seconds;
    while (!condition())
    {
        if (EmulatedArray::now_s() > end_s) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
}
