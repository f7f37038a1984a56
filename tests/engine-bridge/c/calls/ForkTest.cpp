// The child of a program that plays by the C interface.
#include "tests/Forked.h"
#include "tests/engine-bridge/c/Played.h"

#include <atomic>
#include <cstring>
#include <filesystem>
#include <thread>

namespace
{

std::uint64_t sentOf(midair_scene* scene)
{
    midair_device_state state{};
    midair_state(scene, &state);
    return state.sent;
}

/// Returns what is wrong, as a number; 0: nothing.
int closedInChild(midair_scene* scene, midair_solver* solver, midair_object points)
{
    if (stateOf(scene) != MIDAIR_STATE_CLOSED) return 1;
    if (midair_update(scene, 1e6) != MIDAIR_CLOSED) return 2;
    if (!std::strstr(midair_last_error(), "the program has forked")) return 3;
    char told[4096];
    if (midair_messages(scene, told, sizeof told, nullptr) != MIDAIR_OK) return 4;
    if (!std::strstr(told, "the program has forked")) return 5;
    if (midair_mute(scene, 1) != MIDAIR_OK || midair_stop(scene) != MIDAIR_OK) return 6;
    midair_field* field = nullptr;
    if (midair_wait_field(scene, 1e6, &field) != MIDAIR_CLOSED) return 7;
    if (midair_solve(scene, &field) != MIDAIR_OK) return 8;
    midair_point point{};
    if (midair_field_points(field, &point, 1) != MIDAIR_OK || point.object != points) return 9;
    if (midair_solver_close(solver) != MIDAIR_OK) return 10;
    if (midair_scene_close(scene) != MIDAIR_OK) return 11;
    return 0;
}

} // namespace

TEST(CPlay, InTheChildOfAForkAllIsClosedAndTheParentPlaysOn)
{
    Focus of;
    const std::string file = testing::TempDir() + "forked.midair";
    midair_solver* solver = nullptr;
    ASSERT_EQ(midair_set(of.scene, "threads", "2"), MIDAIR_OK);
    ASSERT_EQ(midair_solver_open(of.scene, &solver), MIDAIR_OK) << midair_last_error();
    ASSERT_EQ(midair_play(of.scene, ("record:" + file).c_str()), MIDAIR_OK);
    ASSERT_TRUE(comesTo(of.scene, MIDAIR_STATE_PLAYING)) << of.messages();
    const auto bytes = std::filesystem::file_size(file);
    EXPECT_EQ(inChild([&] { return closedInChild(of.scene, solver, of.points); }), 0);
    // exit() alone, with all that is open.
    EXPECT_EQ(inChild([] { return 0; }), 0);
    EXPECT_EQ(std::filesystem::file_size(file), bytes) << "a child has written to it";
    EXPECT_EQ(stateOf(of.scene), MIDAIR_STATE_PLAYING);
    double moved[16];
    std::copy_n(kIdentity, 16, moved);
    moved[3] = 0.01;
    const std::uint64_t before = sentOf(of.scene);
    ASSERT_EQ(midair_set_pose(of.scene, of.points, moved), MIDAIR_OK);
    EXPECT_TRUE(updatesUntil(of.scene, [&] { return sentOf(of.scene) > before; }));
    EXPECT_EQ(midair_solver_close(solver), MIDAIR_OK);
}

TEST(CPlay, AChildPlaysScenesOfItsOwn)
{
    Focus of;
    ASSERT_EQ(midair_play(of.scene, "sim:"), MIDAIR_OK);
    ASSERT_TRUE(comesTo(of.scene, MIDAIR_STATE_PLAYING)) << of.messages();
    const auto work = [&]
    {
        Focus own;
        if (midair_play(own.scene, "sim:") != MIDAIR_OK) return 1;
        if (!comesTo(own.scene, MIDAIR_STATE_PLAYING)) return 2;
        // That of the parent on another device.
        if (midair_play(of.scene, "sim:") != MIDAIR_OK) return 3;
        return comesTo(of.scene, MIDAIR_STATE_PLAYING) ? 0 : 4;
    };
    EXPECT_EQ(inChild(work), 0);
    EXPECT_EQ(stateOf(of.scene), MIDAIR_STATE_PLAYING);
}

// Whatever other threads of the parent hold just then, no child waits for it.
TEST(CPlay, ForksWhileOtherThreadsCallEndTheirChildren)
{
    Focus of;
    ASSERT_EQ(midair_play(of.scene, "sim:"), MIDAIR_OK);
    ASSERT_TRUE(comesTo(of.scene, MIDAIR_STATE_PLAYING)) << of.messages();
    std::atomic<bool> ends{false};
    std::thread updates(
        [&]
        {
            double time_s = 1e4;
            while (!ends)
                midair_update(of.scene, time_s += 0.01);
        });
    std::thread looks(
        [&]
        {
            while (!ends)
                stateOf(of.scene);
        });
    const auto work = [&]
    {
        midair_device_state state{};
        // Closed as a whole if a thread was at work on it.
        const midair_status status = midair_state(of.scene, &state);
        const bool isClosed = status == MIDAIR_OK && state.state == MIDAIR_STATE_CLOSED;
        midair_scene_close(of.scene);
        return isClosed ? 0 : 1;
    };
    for (int round = 0; round < 20; ++round)
        EXPECT_EQ(inChild(work), 0) << round;
    ends = true;
    updates.join();
    looks.join();
}
