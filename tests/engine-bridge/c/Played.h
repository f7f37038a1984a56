#pragma once

#include "tests/Eventually.h"
#include "tests/engine-bridge/c/Opened.h"

#include <functional>

/// Updates \a scene as a program would until \a reached.
inline bool updatesUntil(midair_scene* scene, const std::function<bool()>& reached)
{
    static double time_s = 0.0;
    return eventually(
        [&]
        {
            midair_update(scene, time_s += 0.01);
            return reached();
        });
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
