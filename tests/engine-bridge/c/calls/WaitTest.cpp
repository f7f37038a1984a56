// Waiting for fields, and what is heard at each ear.
#include "tests/engine-bridge/c/Played.h"

#include <algorithm>
#include <cmath>
#include <thread>
#include <vector>

namespace
{

std::vector<midair_ear> earsOf(midair_scene* scene)
{
    std::vector<midair_ear> ears(70);
    std::size_t count = 0;
    EXPECT_EQ(midair_ears(scene, ears.data(), ears.size(), &count), MIDAIR_OK);
    ears.resize(count);
    return ears;
}

std::uint64_t frameOf(midair_field* field)
{
    midair_field_info info{};
    EXPECT_EQ(midair_field_about(field, &info), MIDAIR_OK);
    EXPECT_EQ(midair_field_close(field), MIDAIR_OK);
    return info.frame;
}

} // namespace

TEST(CPlay, AFieldIsWaitedForOnTheThreadThatUpdates)
{
    Focus of;
    midair_field* field = nullptr;
    EXPECT_EQ(midair_wait_field(of.scene, 1e6, &field), MIDAIR_NOT_YET) << "nothing is played";
    ASSERT_EQ(midair_play(of.scene, "sim:"), MIDAIR_OK);
    EXPECT_EQ(midair_wait_field(of.scene, 1e6, &field), MIDAIR_NOT_YET) << "there was no update";
    EXPECT_EQ(midair_wait_field(of.scene, -1.0, &field), MIDAIR_INVALID);
    EXPECT_EQ(midair_wait_field(of.scene, std::nan(""), &field), MIDAIR_INVALID);
    double place[] = {0.0, 0.0, 0.15};
    for (std::uint64_t frame = 1; frame <= 5; ++frame)
    {
        place[0] = 0.01 * static_cast<double>(frame);
        ASSERT_EQ(midair_move_vertices(of.scene, of.points, place, 1), MIDAIR_OK);
        ASSERT_EQ(midair_update(of.scene, 0.01 * static_cast<double>(frame)), MIDAIR_OK);
        ASSERT_EQ(midair_wait_field(of.scene, 60.0, &field), MIDAIR_OK) << midair_last_error();
        EXPECT_EQ(frameOf(field), frame);
    }
    EXPECT_LT(midair_set(of.scene, "maxPressure", "loud"), 0);
    EXPECT_EQ(midair_wait_field(of.scene, 1e6, &field), MIDAIR_SILENCED);
    ASSERT_EQ(midair_set(of.scene, "maxPressure", "5 kPa"), MIDAIR_OK);
    ASSERT_EQ(midair_stop(of.scene), MIDAIR_OK);
    EXPECT_EQ(midair_wait_field(of.scene, 1e6, &field), MIDAIR_NOT_YET);
}

TEST(CPlay, WhoWaitsForAFieldIsToldThatThePlayingEnds)
{
    Focus of;
    ASSERT_EQ(midair_play(of.scene, "sim:"), MIDAIR_OK);
    ASSERT_EQ(midair_update(of.scene, 0.0), MIDAIR_OK);
    std::thread waits(
        [&]
        {
            midair_field* field = nullptr;
            // It is there, or none comes any more.
            while (midair_wait_field(of.scene, 1e6, &field) == MIDAIR_OK)
                midair_field_close(field);
        });
    midair_field* field = nullptr;
    EXPECT_EQ(midair_wait_field(of.scene, 60.0, &field), MIDAIR_OK) << "not kept by the other";
    midair_field_close(field);
    EXPECT_EQ(midair_stop(of.scene), MIDAIR_OK);
    waits.join();
}

TEST(CPlay, EachEarIsHeardByItself)
{
    Focus of;
    const double ears[] = {0.0, 0.0, 0.16, 0.4, 0.0, 0.3};
    ASSERT_EQ(midair_set_ears(of.scene, ears, 2), MIDAIR_OK) << midair_last_error();
    ASSERT_EQ(midair_set(of.scene, "earPoints", "0 0.5 0.5"), MIDAIR_OK);
    EXPECT_TRUE(earsOf(of.scene).empty());
    ASSERT_EQ(midair_play(of.scene, "sim:"), MIDAIR_OK);
    ASSERT_TRUE(updatesUntil(of.scene,
                             [&]
                             {
                                 const auto all = earsOf(of.scene);
                                 return all.size() == 3 && all[0].level_dB > 0.0;
                             }));
    const std::vector<midair_ear> all = earsOf(of.scene);
    EXPECT_TRUE(std::equal(ears, ears + 3, all[0].position));
    EXPECT_TRUE(std::equal(ears + 3, ears + 6, all[1].position));
    EXPECT_EQ(all[2].position[1], 0.5);
    EXPECT_GT(all[0].level_dB, all[1].level_dB + 10.0) << "it is in the focus";
    EXPECT_GT(all[1].level_dB, 60.0);
    EXPECT_GE(all[0].max_dB, all[0].eq_dB);
    std::size_t count = 0;
    midair_ear one{};
    EXPECT_EQ(midair_ears(of.scene, &one, 1, &count), MIDAIR_TOO_SMALL);
    EXPECT_EQ(count, 3U);
}

TEST(CPlay, AnEarThatIsNowhereSilencesUntilAllAreRight)
{
    Focus of;
    ASSERT_EQ(midair_play(of.scene, "sim:"), MIDAIR_OK);
    ASSERT_TRUE(comesTo(of.scene, MIDAIR_STATE_PLAYING)) << of.messages();
    const double wrong[] = {0.0, 0.0, 0.5, std::nan(""), 0.0, 0.5};
    EXPECT_EQ(midair_set_ears(of.scene, wrong, 2), MIDAIR_INVALID);
    EXPECT_TRUE(comesTo(of.scene, MIDAIR_STATE_SILENT));
    midair_field* field = nullptr;
    EXPECT_EQ(midair_wait_field(of.scene, 1e6, &field), MIDAIR_SILENCED);
    EXPECT_EQ(midair_set_ears(of.scene, wrong, 65), MIDAIR_INVALID);
    ASSERT_EQ(midair_set_ears(of.scene, wrong, 1), MIDAIR_OK);
    EXPECT_TRUE(comesTo(of.scene, MIDAIR_STATE_PLAYING)) << of.messages();
}

TEST(CPlay, TheLimitHoldsAtAnEarThatIsSet)
{
    Focus of;
    const double ear[] = {0.0, 0.0, 0.16};
    ASSERT_EQ(midair_set(of.scene, "earLimit", "120"), MIDAIR_OK);
    const Solved free(of.scene);
    ASSERT_EQ(free.status, MIDAIR_OK) << free.why;
    ASSERT_EQ(midair_set_ears(of.scene, ear, 1), MIDAIR_OK);
    const Solved held(of.scene);
    ASSERT_EQ(held.status, MIDAIR_OK) << held.why;
    EXPECT_LT(held.figure("level_Pa"), 0.9 * free.figure("level_Pa"));
    EXPECT_LE(held.figure("exposure.level_dB"), 120.0);
    ASSERT_EQ(midair_play(of.scene, "sim:"), MIDAIR_OK);
    ASSERT_TRUE(comesTo(of.scene, MIDAIR_STATE_PLAYING)) << of.messages();
    midair_field* field = nullptr;
    ASSERT_EQ(midair_wait_field(of.scene, 60.0, &field), MIDAIR_OK) << midair_last_error();
    midair_field_close(field);
    EXPECT_LE(earsOf(of.scene).at(0).level_dB, 120.0);
}
