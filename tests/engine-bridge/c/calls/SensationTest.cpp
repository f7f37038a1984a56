// midair_add_sensation() and what plays of it.
#include "tests/engine-bridge/c/Played.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <midair_play.h>

namespace
{

/// A circle of 10 mm over a board, which the program begins.
struct Circle : Opened
{
    Circle() : Opened("board")
    {
        EXPECT_EQ(midair_add_sensation(scene, "circle?radius=10mm", &circle), MIDAIR_OK)
            << midair_last_error();
        const double over[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0.15, 0, 0, 0, 1};
        EXPECT_EQ(midair_set_pose(scene, circle, over), MIDAIR_OK);
        EXPECT_EQ(midair_object_set(scene, circle, "pressure", "500 Pa"), MIDAIR_OK);
        EXPECT_EQ(midair_object_set(scene, circle, "trigger", "program"), MIDAIR_OK);
    }

    midair_sensation newest() const
    {
        midair_sensation list[2] = {};
        size_t count = 0;
        EXPECT_EQ(midair_sensations(scene, list, 2, &count), MIDAIR_OK);
        return list[0];
    }

    midair_object circle = 0;
};

/// The newest field of a scene; null: none yet.
struct Newest
{
    explicit Newest(midair_scene* scene)
    {
        if (midair_newest_field(scene, &field) >= 0) midair_field_about(field, &info);
    }
    ~Newest()
    {
        if (field) midair_field_close(field);
    }
    Newest(const Newest&) = delete;
    Newest& operator=(const Newest&) = delete;

    midair_field* field = nullptr;
    midair_field_info info{};
};

} // namespace

TEST(CPlay, SensationsBeginAndEndByTheProgram)
{
    Circle of;
    ASSERT_EQ(midair_play(of.scene, "sim:"), MIDAIR_OK);
    ASSERT_TRUE(updatesUntil(of.scene, [&] { return of.newest().object == of.circle; }));
    EXPECT_EQ(of.newest().playing, 0);
    ASSERT_EQ(midair_sensation_play(of.scene, of.circle, 1), MIDAIR_OK);
    // The first sample stands at a pattern time of 0.
    ASSERT_TRUE(updatesUntil(of.scene, [&] { return of.newest().pattern_time_ms > 0.0; }))
        << of.messages();
    const midair_sensation playing = of.newest();
    EXPECT_EQ(playing.intensity, 1.0);
    EXPECT_EQ(playing.playing, 1);
    EXPECT_EQ(playing.stopped, 0);
    EXPECT_NEAR(std::hypot(playing.position[0], playing.position[1]), 0.01, 1e-6);
    EXPECT_NEAR(playing.position[2], 0.15, 1e-9);
    EXPECT_NEAR(playing.pressure_Pa, 500.0, 1e-6);
    EXPECT_TRUE(comesTo(of.scene, MIDAIR_STATE_PLAYING));
    ASSERT_EQ(midair_object_set(of.scene, of.circle, "parameters", "radius=5"), MIDAIR_OK);
    EXPECT_TRUE(updatesUntil(of.scene,
                             [&]
                             {
                                 const midair_sensation now = of.newest();
                                 return std::abs(std::hypot(now.position[0], now.position[1]) -
                                                 0.005) < 1e-6;
                             }));
    ASSERT_EQ(midair_sensation_play(of.scene, of.circle, 0), MIDAIR_OK);
    EXPECT_TRUE(updatesUntil(of.scene, [&] { return of.newest().playing == 0; }));
    EXPECT_TRUE(comesTo(of.scene, MIDAIR_STATE_SILENT));
}

// Silence is the same promise, whatever plays.
struct CPlaySensations : ::testing::Test
{
    void play(const char* device)
    {
        ASSERT_EQ(midair_sensation_play(of.scene, of.circle, 1), MIDAIR_OK);
        ASSERT_EQ(midair_play(of.scene, device), MIDAIR_OK);
    }
    void begin(const char* device)
    {
        play(device);
        ASSERT_TRUE(updatesUntil(of.scene, [&] { return of.newest().intensity > 0.0; }))
            << of.messages();
        ASSERT_TRUE(comesTo(of.scene, MIDAIR_STATE_PLAYING)) << of.messages();
    }
    bool stopsPlaying()
    {
        return updatesUntil(of.scene, [&] { return stateOf(of.scene) != MIDAIR_STATE_PLAYING; });
    }

    Circle of;
};

TEST_F(CPlaySensations, AreSilentWhenNobodyLeads)
{
    begin("sim:?hold=200ms");
    EXPECT_TRUE(eventually([&] { return stateOf(of.scene) == MIDAIR_STATE_SILENT; }));
    EXPECT_TRUE(comesTo(of.scene, MIDAIR_STATE_PLAYING)) << "somebody does again";
}

TEST_F(CPlaySensations, AreMutedAndSwitchedOff)
{
    begin("sim:");
    ASSERT_EQ(midair_mute(of.scene, 1), MIDAIR_OK);
    EXPECT_TRUE(comesTo(of.scene, MIDAIR_STATE_MUTED));
    ASSERT_EQ(midair_mute(of.scene, 0), MIDAIR_OK);
    EXPECT_TRUE(comesTo(of.scene, MIDAIR_STATE_PLAYING));
    ASSERT_EQ(midair_set(of.scene, "enabled", "false"), MIDAIR_OK);
    EXPECT_TRUE(stopsPlaying());
    ASSERT_EQ(midair_set(of.scene, "enabled", "true"), MIDAIR_OK);
    EXPECT_TRUE(comesTo(of.scene, MIDAIR_STATE_PLAYING));
    EXPECT_NE(midair_object_set(of.scene, of.circle, "pressure", "much"), MIDAIR_OK);
    EXPECT_TRUE(stopsPlaying()) << "a pressure that isn't understood";
}

TEST_F(CPlaySensations, StayUnderTheCaps)
{
    ASSERT_EQ(midair_set(of.scene, "maxPressure", "100 Pa"), MIDAIR_OK);
    begin("sim:");
    std::vector<midair_point> points(16);
    EXPECT_TRUE(updatesUntil(of.scene,
                             [&]
                             {
                                 Newest newest(of.scene);
                                 if (!newest.field || newest.info.points != 1) return false;
                                 EXPECT_EQ(midair_field_points(newest.field, points.data(), 16),
                                           MIDAIR_OK);
                                 EXPECT_LE(points[0].achieved_Pa, 100.0 * 1.001);
                                 return points[0].achieved_Pa > 50.0;
                             }));
    ASSERT_EQ(midair_set(of.scene, "maxAmplitude", "0"), MIDAIR_OK);
    EXPECT_TRUE(stopsPlaying());
}

TEST_F(CPlaySensations, AreLostWithTheirDevice)
{
    // On a busy machine an early loss comes before anything is played.
    bool played = false;
    for (int seconds = 2; seconds <= 32 && !played; seconds *= 4)
    {
        play(("sim:?unplug_at=" + std::to_string(seconds) + "s").c_str());
        EXPECT_TRUE(updatesUntil(of.scene,
                                 [&]
                                 {
                                     const int32_t state = stateOf(of.scene);
                                     played |= state == MIDAIR_STATE_PLAYING;
                                     return state == MIDAIR_STATE_LOST;
                                 }));
    }
    EXPECT_TRUE(played) << of.messages();
}

TEST(CScene, SensationsAreRefusedByName)
{
    Circle of;
    midair_object other = 0;
    EXPECT_EQ(midair_add_sensation(of.scene, "cirle", &other), MIDAIR_REFUSED);
    EXPECT_NE(std::string(midair_last_error()).find("circle"), std::string::npos);
    EXPECT_EQ(midair_add_sensation(of.scene, " ", &other), MIDAIR_INVALID);
    EXPECT_EQ(midair_add_sensation(of.scene, nullptr, &other), MIDAIR_INVALID);
    EXPECT_EQ(midair_add_sensation(of.scene, "circle", nullptr), MIDAIR_INVALID);
    EXPECT_EQ(midair_add_sensation(of.scene, "{\"no\": \"pattern\"}", &other), MIDAIR_REFUSED);
    EXPECT_EQ(midair_object_set(of.scene, of.circle, "parameters", "nosuch=1"), MIDAIR_INVALID);
    EXPECT_EQ(midair_object_set(of.scene, of.circle, "attach", "hand:nose"), MIDAIR_INVALID);
    EXPECT_EQ(midair_object_set(of.scene, of.circle, "trigger", "touch-stay"), MIDAIR_OK);
    EXPECT_EQ(midair_sensation_play(of.scene, of.circle, 1), MIDAIR_INVALID);
    EXPECT_EQ(midair_sensation_play(of.scene, of.circle + 100, 1), MIDAIR_UNKNOWN);
    size_t count = 7;
    EXPECT_EQ(midair_sensations(of.scene, nullptr, 0, &count), MIDAIR_OK);
    EXPECT_EQ(count, 0u) << "nothing plays";
}

// A single field has no time in which a sensation could take its course.
TEST(CScene, ASolveLeavesSensationsOutAndSaysSo)
{
    Circle of;
    const Solved solved(of.scene);
    EXPECT_EQ(solved.status, MIDAIR_SILENT);
    EXPECT_NE(of.messages().find("sensation"), std::string::npos) << of.messages();
}
