// Fields beyond their process.
#include "tests/engine-bridge/c/Opened.h"

namespace
{

std::vector<unsigned char> bytesOf(const midair_field* field)
{
    size_t needed = 0;
    EXPECT_EQ(midair_field_bytes(field, nullptr, 0, &needed), MIDAIR_OK) << midair_last_error();
    std::vector<unsigned char> bytes(needed);
    EXPECT_EQ(midair_field_bytes(field, bytes.data(), needed - 1, nullptr), MIDAIR_TOO_SMALL);
    EXPECT_EQ(midair_field_bytes(field, bytes.data(), needed, nullptr), MIDAIR_OK);
    return bytes;
}

} // namespace

TEST(CFieldBytes, AFieldOfItsBytesIsEqual)
{
    Opened of("board");
    const double places[] = {0.0, 0.0, 0.15, 0.02, 0.0, 0.14};
    midair_object points = 0;
    ASSERT_EQ(midair_add_points(of.scene, places, nullptr, 2, 0, &points), MIDAIR_OK);
    const Solved solved(of.scene);
    ASSERT_EQ(solved.status, MIDAIR_OK) << solved.why;
    const std::vector<unsigned char> bytes = bytesOf(solved.field);
    midair_field* again = nullptr;
    ASSERT_EQ(midair_field_from_bytes(bytes.data(), bytes.size(), &again), MIDAIR_OK)
        << midair_last_error();
    EXPECT_EQ(bytesOf(again), bytes);
    std::vector<float> before(4);
    std::vector<float> after(4);
    EXPECT_EQ(midair_field_pressures(solved.field, 0, places, 2, before.data()), MIDAIR_OK);
    EXPECT_EQ(midair_field_pressures(again, 0, places, 2, after.data()), MIDAIR_OK);
    EXPECT_EQ(after, before);
    double level_dB = 0.0;
    EXPECT_EQ(midair_field_figure(again, "exposure.level_dB", &level_dB), MIDAIR_OK);
    EXPECT_EQ(level_dB, solved.figure("exposure.level_dB"));
    double force_N = 0.0;
    EXPECT_EQ(midair_field_figure(again, "fingertipForce_N", &force_N), MIDAIR_OK);
    EXPECT_EQ(force_N, solved.figure("fingertipForce_N"));
    midair_point point{};
    EXPECT_EQ(midair_field_points(again, &point, 1), MIDAIR_TOO_SMALL);
    EXPECT_EQ(midair_field_close(again), MIDAIR_OK);
}

TEST(CFieldBytes, OfSilenceSaysWhy)
{
    Opened of("board");
    const Solved solved(of.scene);
    ASSERT_EQ(solved.status, MIDAIR_SILENT);
    const std::vector<unsigned char> bytes = bytesOf(solved.field);
    midair_field* again = nullptr;
    EXPECT_EQ(midair_field_from_bytes(bytes.data(), bytes.size(), &again), MIDAIR_SILENT);
    EXPECT_EQ(midair_last_error(), solved.why);
    EXPECT_EQ(midair_field_close(again), MIDAIR_OK);
}

// Whatever byte is wrong: an error, or a field that can be asked; never a fault.
TEST(CFieldBytes, OthersAreRefused)
{
    Opened of("ultraino64");
    const double place[] = {0.0, 0.0, 0.15};
    midair_object points = 0;
    ASSERT_EQ(midair_add_points(of.scene, place, nullptr, 1, 0, &points), MIDAIR_OK);
    const Solved solved(of.scene);
    const std::vector<unsigned char> bytes = bytesOf(solved.field);
    midair_field* again = nullptr;
    EXPECT_EQ(midair_field_from_bytes(nullptr, 5, &again), MIDAIR_INVALID);
    EXPECT_EQ(midair_field_from_bytes(bytes.data(), 0, &again), MIDAIR_REFUSED);
    for (std::size_t end = 1; end < bytes.size(); end += bytes.size() / 97)
        EXPECT_EQ(midair_field_from_bytes(bytes.data(), end, &again), MIDAIR_REFUSED) << end;
    int refused = 0;
    for (std::size_t at = 0; at < bytes.size(); at += 7)
    {
        std::vector<unsigned char> wrong = bytes;
        wrong[at] = static_cast<unsigned char>(wrong[at] ^ 0xff);
        if (midair_field_from_bytes(wrong.data(), wrong.size(), &again) < 0)
        {
            ++refused;
            continue;
        }
        midair_point point{};
        midair_field_info info{};
        ASSERT_EQ(midair_field_about(again, &info), MIDAIR_OK);
        if (info.points == 1) midair_field_points(again, &point, 1);
        std::vector<int32_t> levels(2 * std::size_t(info.transducers));
        midair_field_levels(
            again, 0, levels.data(), levels.data() + info.transducers, info.transducers);
        float p[2] = {};
        midair_field_pressures(again, 0, place, 1, p);
        EXPECT_EQ(midair_field_close(again), MIDAIR_OK);
    }
    EXPECT_GT(refused, 10);
}
