#pragma once

#include "tests/engine-bridge/c/Opened.h"

#include <chrono>
#include <functional>
#include <thread>

/// Updates \a scene as a program would until \a reached; returns false after 20 s.
inline bool updatesUntil(midair_scene* scene, const std::function<bool()>& reached)
{
    const auto begin = std::chrono::steady_clock::now();
    static double time_s = 0.0;
    while (std::chrono::steady_clock::now() - begin < std::chrono::seconds(20))
    {
        midair_update(scene, time_s += 0.01);
        if (reached()) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
}

inline int32_t stateOf(midair_scene* scene)
{
    midair_device_state state{};
    EXPECT_EQ(midair_state(scene, &state), MIDAIR_OK);
    return state.state;
}

inline bool comesTo(midair_scene* scene, int32_t state)
{
    return updatesUntil(scene, [&] { return stateOf(scene) == state; });
}

/// A focus over a board.
struct Focus : Opened
{
    Focus() : Opened("board")
    {
        const double place[] = {0.0, 0.0, 0.15};
        EXPECT_EQ(midair_add_points(scene, place, nullptr, 1, 0, &points), MIDAIR_OK);
    }
    midair_object points = 0;
};
