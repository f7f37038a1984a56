#pragma once

#include <chrono>

namespace midair::base
{

/// Seconds of the steady clock: what time stamps of fields, snapshots and hands count in.
inline double steadySeconds()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

} // namespace midair::base
