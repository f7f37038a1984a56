// midair_set_reflectors(): the same drives as with an array's own, followed, and refused by name.
#include "tests/engine-bridge/c/Played.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace
{

const std::string kPlate =
    R"({"name": "plate", "position_m": [0, 0, -0.05], "normal": [0, 0, 1], "along": [1, 0, 0],
        "size_m": [0.4, 0.3], "accuracy_mm": 0.2})";

std::string listOf(const std::string& plates)
{
    return "{\"reflectors\": [" + plates + "]}";
}

std::string deskOf(const std::string& more)
{
    return R"({"frequency_Hz": 40000, "sourceAmplitude_Pa_m": 10.1, "directivity": "t4010a1-table",
        "boards": [{"position_m": [0, -0.1, 0], "normal": [0, 1, 0], "columns": 10, "rows": 10,
                    "pitch_m": 0.0105}])" +
           more + "}";
}

/// Four points before a board.
class DeskOfC : public Opened
{
public:
    explicit DeskOfC(const std::string& json) : Opened(json.c_str(), midair_array_from_json)
    {
        const double places[] = {
            0.0, 0.05, 0.0, 0.02, 0.05, 0.0, 0.0, 0.05, 0.02, 0.01, 0.07, 0.01};
        EXPECT_EQ(midair_add_points(scene, places, nullptr, 4, 0, &points), MIDAIR_OK);
    }

    std::vector<float> solved() const
    {
        const Solved solved(scene);
        EXPECT_EQ(solved.status, MIDAIR_OK) << solved.why;
        return solved.activations();
    }
    /// Of the field of the next update.
    std::vector<float> played(double time_s) const
    {
        midair_field* field = nullptr;
        EXPECT_EQ(midair_update(scene, time_s), MIDAIR_OK) << midair_last_error();
        EXPECT_EQ(midair_wait_field(scene, 60.0, &field), MIDAIR_OK) << midair_last_error();
        std::vector<float> q(200);
        EXPECT_EQ(midair_field_activations(field, 0, q.data(), 100), MIDAIR_OK)
            << midair_last_error();
        midair_field_close(field);
        return q;
    }

    midair_object points = 0;
};

/// Mean square by which two drives differ, per transducer.
double apart(const std::vector<float>& a, const std::vector<float>& b)
{
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += std::pow(static_cast<double>(a[i]) - static_cast<double>(b[i]), 2);
    return sum / 100.0;
}

} // namespace

TEST(CReflectors, AreSolvedForAsAnArraysOwn)
{
    const std::string more = ", \"reflectors\": [" + kPlate + "]";
    const DeskOfC free(deskOf("")), own(deskOf(more)), set(deskOf(""));
    ASSERT_EQ(midair_set_reflectors(set.scene, listOf(kPlate).c_str()), MIDAIR_OK)
        << midair_last_error();
    EXPECT_EQ(set.solved(), own.solved());
    EXPECT_GT(apart(set.solved(), free.solved()), 0.01);
    for (const char* none : {"", static_cast<const char*>(nullptr)})
    {
        ASSERT_EQ(midair_set_reflectors(set.scene, listOf(kPlate).c_str()), MIDAIR_OK);
        ASSERT_EQ(midair_set_reflectors(set.scene, none), MIDAIR_OK);
        EXPECT_EQ(set.solved(), free.solved());
    }
}

TEST(CReflectors, AreFollowedWhileAFieldPlays)
{
    const DeskOfC desk(deskOf("")), still(deskOf(", \"reflectors\": [" + kPlate + "]"));
    for (const DeskOfC* one : {&desk, &still})
        ASSERT_EQ(midair_play(one->scene, "sim:"), MIDAIR_OK) << midair_last_error();
    const std::vector<float> free = desk.played(0.0), beside = still.played(0.0);
    ASSERT_EQ(midair_set_reflectors(desk.scene, listOf(kPlate).c_str()), MIDAIR_OK);
    EXPECT_GT(apart(desk.played(0.1), free), 0.01) << "nothing else has changed";
    std::string moved = kPlate;
    moved.replace(moved.find("-0.05"), 5, "-0.06");
    ASSERT_EQ(midair_set_reflectors(desk.scene, listOf(moved).c_str()), MIDAIR_OK);
    const std::vector<float> there = desk.played(0.2);
    EXPECT_GT(apart(there, beside), 0.01);
    EXPECT_EQ(stateOf(desk.scene), MIDAIR_STATE_PLAYING);
}

TEST(CReflectors, WhatIsWrongSilencesUntilItIsRight)
{
    const DeskOfC desk(deskOf(""));
    ASSERT_EQ(midair_play(desk.scene, "sim:"), MIDAIR_OK) << midair_last_error();
    ASSERT_TRUE(comesTo(desk.scene, MIDAIR_STATE_PLAYING)) << desk.messages();
    std::string often = kPlate;
    for (int k = 1; k < 9; ++k)
        often += "," + kPlate;
    for (const std::string& wrong : {std::string("{"),
                                     listOf(R"({"position_m": [0, 0, 0], "normal": [0, 0, 1]})"),
                                     listOf(often),
                                     std::string(2000000, ' ')})
    {
        EXPECT_EQ(midair_set_reflectors(desk.scene, wrong.c_str()), MIDAIR_INVALID);
        EXPECT_NE(std::string(midair_last_error()).find("nothing is played"), std::string::npos)
            << midair_last_error();
        EXPECT_TRUE(comesTo(desk.scene, MIDAIR_STATE_SILENT));
        const Solved solved(desk.scene);
        EXPECT_NE(solved.status, MIDAIR_OK);
        ASSERT_EQ(midair_set_reflectors(desk.scene, listOf(kPlate).c_str()), MIDAIR_OK);
        EXPECT_TRUE(comesTo(desk.scene, MIDAIR_STATE_PLAYING)) << desk.messages();
    }
}

TEST(CReflectors, WhatIsLeftOutIsTold)
{
    const DeskOfC desk(deskOf(""));
    std::string rough = kPlate;
    rough.replace(rough.find("0.2}"), 3, "5.0");
    ASSERT_EQ(midair_set_reflectors(desk.scene, listOf(rough).c_str()), MIDAIR_OK);
    ASSERT_EQ(midair_play(desk.scene, "sim:"), MIDAIR_OK) << midair_last_error();
    const std::vector<float> q = desk.played(0.0);
    EXPECT_NE(desk.messages().find("fields aren't corrected for reflector 'plate'"),
              std::string::npos)
        << desk.messages();
    EXPECT_LT(apart(q, DeskOfC(deskOf("")).solved()), 0.05) << "as in free air";
}
