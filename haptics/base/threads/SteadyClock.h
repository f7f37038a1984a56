#pragma once

#include <chrono>

namespace midair::base
{

/// Returns the time of the steady clock in seconds, which time stamps of fields and snapshots use.
inline double steadySeconds()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

} // namespace midair::base
