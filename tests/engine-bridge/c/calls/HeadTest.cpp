// Where the viewer's head is, in C.
#include "tests/engine-bridge/c/Played.h"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>

namespace
{

midair_head headAt(double x, double y, double z)
{
    midair_head head{};
    head.position[0] = x;
    head.position[1] = y;
    head.position[2] = z;
    head.orientation[3] = 1.0;
    return head;
}

void* openCap(void* user, const char* options, char* error, size_t size)
{
    if (std::string(options) == "none")
    {
        std::snprintf(error, size, "no cap there");
        return nullptr;
    }
    return user;
}

int32_t headOfCap(void* instance, double, midair_head* head)
{
    *head = headAt(*static_cast<double*>(instance), 0.0, 0.3);
    return 1;
}

/// How many places of the program's are listened at.
std::size_t headEarsOf(midair_scene* scene)
{
    std::size_t count = 0;
    midair_ear ears[8];
    midair_ears(scene, ears, 8, &count);
    return count;
}

} // namespace

TEST(CHead, IsSetAndItsEarsAreListenedAt)
{
    Focus of;
    midair_head last{};
    EXPECT_EQ(midair_last_head(of.scene, &last), MIDAIR_NOT_YET);
    const midair_head head = headAt(0.0, -0.3, 0.2);
    ASSERT_EQ(midair_set_head(of.scene, &head), MIDAIR_OK) << midair_last_error();
    ASSERT_EQ(midair_play(of.scene, "sim:"), MIDAIR_OK) << midair_last_error();
    ASSERT_TRUE(updatesUntil(of.scene,
                             [&]
                             {
                                 midair_set_head(of.scene, &head);
                                 return headEarsOf(of.scene) == 2;
                             }))
        << of.messages();
    ASSERT_EQ(midair_last_head(of.scene, &last), MIDAIR_OK);
    EXPECT_EQ(last.position[1], -0.3);
    EXPECT_NEAR(last.orientation[3], 1.0, 1e-9);
    // One that is lost, as nobody sets it, is listened at where it was.
    ASSERT_TRUE(updatesUntil(of.scene,
                             [&] { return midair_last_head(of.scene, &last) == MIDAIR_NOT_YET; }));
    EXPECT_EQ(headEarsOf(of.scene), 2u);
    EXPECT_NE(of.messages().find("the head is lost"), std::string::npos) << of.messages();
    ASSERT_EQ(midair_set_head(of.scene, nullptr), MIDAIR_OK);
    EXPECT_TRUE(updatesUntil(of.scene, [&] { return headEarsOf(of.scene) == 0; }));
}

TEST(CHead, ThatCantBeIsAnError)
{
    Opened of;
    midair_head wrong = headAt(std::nan(""), 0.0, 0.0);
    EXPECT_EQ(midair_set_head(of.scene, &wrong), MIDAIR_INVALID);
    wrong = headAt(0.0, 2000.0, 0.0);
    EXPECT_EQ(midair_set_head(of.scene, &wrong), MIDAIR_INVALID);
    EXPECT_EQ(std::string(midair_last_error()),
              "the head is at (0, 2000, 0) m; it must be within 1000 m");
    wrong = headAt(0.0, 0.0, 0.0);
    wrong.orientation[3] = 2.0;
    EXPECT_EQ(midair_set_head(of.scene, &wrong), MIDAIR_INVALID);
    wrong = headAt(0.0, 0.0, 0.0);
    wrong.age_s = -1.0;
    EXPECT_EQ(midair_set_head(of.scene, &wrong), MIDAIR_INVALID);
    EXPECT_EQ(midair_set_head(nullptr, &wrong), MIDAIR_CLOSED);
    EXPECT_EQ(midair_last_head(of.scene, nullptr), MIDAIR_INVALID);
}

TEST(CHead, IsOpenedByANameOrOfOnesOwn)
{
    Opened of;
    EXPECT_EQ(midair_open_head(of.scene, "opnxr:"), MIDAIR_UNKNOWN);
    EXPECT_NE(std::string(midair_last_error()).find("(did you mean openxr?)"), std::string::npos);
    EXPECT_EQ(midair_open_head(of.scene, "mouse:"), MIDAIR_UNKNOWN);
    EXPECT_EQ(midair_open_head(of.scene, "fixed 0 0"), MIDAIR_REFUSED);
    ASSERT_EQ(midair_open_head(of.scene, "fixed 0 -0.3 0.4"), MIDAIR_OK) << midair_last_error();
    double x = 0.25;
    midair_head_source source{};
    source.user = &x;
    source.open = openCap;
    source.head = headOfCap;
    EXPECT_EQ(midair_register_head("cap", &source), MIDAIR_INVALID) << "no struct_size";
    source.struct_size = sizeof source;
    ASSERT_EQ(midair_register_head("cap", &source), MIDAIR_OK) << midair_last_error();
    EXPECT_EQ(midair_register_head("osc", &source), MIDAIR_REFUSED);
    EXPECT_EQ(midair_open_head(of.scene, "cap:none"), MIDAIR_REFUSED);
    EXPECT_NE(std::string(midair_last_error()).find("no cap there"), std::string::npos);
    ASSERT_EQ(midair_open_head(of.scene, "cap:"), MIDAIR_OK) << midair_last_error();
    ASSERT_EQ(midair_play(of.scene, "sim:"), MIDAIR_OK) << midair_last_error();
    midair_head last{};
    EXPECT_TRUE(
        updatesUntil(of.scene, [&] { return midair_last_head(of.scene, &last) == MIDAIR_OK; }));
    EXPECT_EQ(last.position[0], 0.25);
    EXPECT_EQ(midair_open_head(of.scene, "none"), MIDAIR_OK);
}

namespace
{

/// A plate whose picture's place is known, and how far off its parts may be.
std::string displayFile()
{
    std::string path = ::testing::TempDir() + "midair-c-display.json";
    std::ofstream(path) << R"({
  "screen": { "lowerLeft_m": [-0.172, 0.203, -0.15], "lowerRight_m": [0.172, 0.203, -0.15],
              "upperLeft_m": [-0.172, 0.397, -0.15], "pixels": [1920, 1080] },
  "optics": [ { "kind": "plate", "point_m": [0, 0.30, 0.15], "normal": [0, -1, 1] } ],
  "eye": "fixed 0 -0.60 0.25", "ipd_m": 0.063, "stereo": "side-by-side", "accuracy_mm": 2 })";
    return path;
}

midair_coincidence coincidenceIn(midair_scene* scene)
{
    midair_coincidence all[16]{};
    std::size_t count = 0;
    EXPECT_EQ(midair_list_coincidence(scene, all, 16, &count), MIDAIR_OK) << midair_last_error();
    return count == 1 ? all[0] : midair_coincidence{};
}

} // namespace

TEST(CCoincidence, IsUnknownUntilAllOfItIsKnown)
{
    Focus of;
    std::size_t count = 1;
    EXPECT_EQ(midair_list_coincidence(of.scene, nullptr, 0, &count), MIDAIR_OK);
    EXPECT_EQ(count, 0u) << "nothing is played";
    ASSERT_EQ(midair_play(of.scene, "sim:"), MIDAIR_OK) << midair_last_error();
    ASSERT_TRUE(updatesUntil(of.scene, [&] { return coincidenceIn(of.scene).object != 0; }));
    midair_coincidence now = coincidenceIn(of.scene);
    EXPECT_EQ(now.object, of.points);
    EXPECT_EQ(now.state[MIDAIR_PART_TOTAL], MIDAIR_PART_UNKNOWN);
    EXPECT_EQ(now.state[MIDAIR_PART_ARRAY], MIDAIR_PART_NONE);
    EXPECT_EQ(now.state[MIDAIR_PART_TRACKER], MIDAIR_PART_NONE);
    EXPECT_EQ(now.state[MIDAIR_PART_MOTION], MIDAIR_PART_KNOWN);
    EXPECT_STREQ(now.unknown, "no display is known; airError isn't set");

    EXPECT_NE(midair_set_display(of.scene, "no such file"), MIDAIR_OK);
    ASSERT_EQ(midair_set_display(of.scene, displayFile().c_str()), MIDAIR_OK)
        << midair_last_error();
    ASSERT_EQ(midair_set(of.scene, "headError", "10 mm"), MIDAIR_OK) << midair_last_error();
    ASSERT_EQ(midair_set(of.scene, "airError", "1 C"), MIDAIR_OK) << midair_last_error();
    ASSERT_TRUE(updatesUntil(
        of.scene,
        [&] { return coincidenceIn(of.scene).state[MIDAIR_PART_TOTAL] == MIDAIR_PART_KNOWN; }))
        << coincidenceIn(of.scene).unknown;
    now = coincidenceIn(of.scene);
    EXPECT_STREQ(now.unknown, "");
    EXPECT_STREQ(now.largest, "display");
    EXPECT_NEAR(now.median_m[MIDAIR_PART_DISPLAY], 2e-3, 3e-4); // the picture is at the focus
    EXPECT_GT(now.most_m[MIDAIR_PART_TOTAL], now.median_m[MIDAIR_PART_TOTAL]);
    EXPECT_GT(now.median_m[MIDAIR_PART_TOTAL], now.median_m[MIDAIR_PART_DISPLAY]);

    ASSERT_EQ(midair_set_display(of.scene, ""), MIDAIR_OK) << midair_last_error();
    EXPECT_TRUE(updatesUntil(
        of.scene,
        [&] { return coincidenceIn(of.scene).state[MIDAIR_PART_TOTAL] == MIDAIR_PART_UNKNOWN; }));
}
