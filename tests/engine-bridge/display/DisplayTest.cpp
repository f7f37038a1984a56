#include "engine-bridge/display/Display.h"

#include "haptics/base/InputError.h"
#include "tests/engine-bridge/display/LightTracer.h"

#include <limits>

#include <gtest/gtest.h>

namespace midair::bridge
{

namespace
{

const char* const kMirror = R"({
  "about": "a half mirror over one board",
  "screen": {"lowerLeft_m": [0.26, -0.40, 0.40], "lowerRight_m": [-0.26, -0.40, 0.40],
             "upperLeft_m": [0.26, -0.10, 0.40], "pixels": [1920, 1080]},
  "optics": [{"kind": "half-mirror", "point_m": [0, -0.25, 0.15], "normal": [0, -1, 1],
              "outline_m": [[-0.3, -0.4, 0], [0.3, -0.4, 0], [0.3, -0.1, 0.3], [-0.3, -0.1, 0.3]]}],
  "eye": "fixed 0 -0.8 0.3",
  "ipd_m": 0.062,
  "stereo": "side-by-side"
})";

std::string replaced(const std::string& from, const std::string& to)
{
    std::string text = kMirror;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

std::string errorOf(const std::string& text)
{
    try
    {
        readDisplay(text, "a");
    }
    catch (const base::InputError& error)
    {
        return error.what();
    }
    return {};
}

} // namespace

TEST(DisplayFile, IsRead)
{
    const Display display = readDisplay(kMirror, "a");
    EXPECT_EQ(display.lowerRight, Eigen::Vector3d(-0.26, -0.40, 0.40));
    EXPECT_EQ(display.width, 1920);
    ASSERT_EQ(display.optics.size(), 1U);
    EXPECT_EQ(display.optics[0].kind, Optic::Kind::HALF_MIRROR);
    EXPECT_NEAR(display.optics[0].normal.norm(), 1.0, 1e-12);
    EXPECT_EQ(display.optics[0].outline.size(), 4U);
    EXPECT_EQ(display.eye, "fixed 0 -0.8 0.3");
    EXPECT_EQ(display.ipd_m, 0.062);
    EXPECT_EQ(display.stereo, StereoMode::SIDE_BY_SIDE);
}

TEST(DisplayFile, SaysWhatIsWrong)
{
    EXPECT_EQ(errorOf(replaced("[0.26, -0.10, 0.40]", "[0.25, -0.10, 0.40]")),
              "a: screen corners are no rectangle within 1 %: at lowerLeft_m is an angle of 88.1 "
              "degrees");
    EXPECT_EQ(errorOf(replaced("[0.26, -0.10, 0.40]", "[0.2595, -0.10, 0.40]")), "");
    EXPECT_EQ(errorOf(replaced("\"half-mirror\"", "\"mirror\"")),
              "a: optics[0].kind is \"mirror\"; it must be half-mirror or plate");
    EXPECT_EQ(errorOf(replaced("\"half-mirror\"", "\"halfmirror\"")),
              "a: optics[0].kind is \"halfmirror\"; it must be half-mirror or plate (did you mean "
              "half-mirror?)");
    EXPECT_NE(errorOf(replaced("[0.26, -0.10, 0.40]", "[NaN, -0.10, 0.40]")).find("a: not JSON: "),
              std::string::npos);
    EXPECT_EQ(errorOf(replaced("[0.26, -0.10, 0.40]", "[260, -0.10, 0.40]")),
              "a: screen.upperLeft_m is [260,-0.1,0.4]; it must be a place [x, y, z] in metres, "
              "each within 100");
    EXPECT_EQ(errorOf(replaced("\"pixels\": [1920, 1080]",
                               "\"pixels\": [1920, 1080], \"upperRight_m\": [-0.26, -0.08, 0.4]")),
              "a: screen.upperRight_m is 0.02 m from where it makes a rectangle of the other "
              "corners, [-0.26, -0.1, 0.4]; within 1 % are 0.006003 m");
    EXPECT_EQ(errorOf(replaced("side-by-side", "side-to-side")),
              "a: stereo is \"side-to-side\"; it must be one of none, quad-buffer, anaglyph, "
              "side-by-side, top-bottom, left-eye, right-eye, horizontal-interlace, "
              "vertical-interlace, checkerboard (did you mean side-by-side?)");
    EXPECT_EQ(errorOf(replaced("0.062", "62")), "a: ipd_m is 62; it must be 0 .. 0.1 m");
    EXPECT_EQ(
        errorOf(replaced("[0.3, -0.1, 0.3]", "[0.3, -0.1, 0.31]")),
        "a: optics[0] outline_m[2] is 0.007071 m off the plane of point_m and normal; at most "
        "0.001 m are possible");
    EXPECT_EQ(
        errorOf(replaced("[0.3, -0.4, 0], [0.3, -0.1, 0.3]", "[0.3, -0.1, 0.3], [0.3, -0.4, 0]")),
        "a: optics[0] outline_m isn't convex: its corners must go around, with no dent");
    EXPECT_EQ(errorOf(replaced("\"ipd_m\"", "\"ipd\"")),
              "a: has the unknown key 'ipd'; known are about, screen, optics, eye, ipd_m, stereo, "
              "accuracy_mm, accuracy_deg");
}

TEST(DisplayFile, MaySayHowAccurateItIs)
{
    EXPECT_FALSE(readDisplay(kMirror, "a").accuracy_m);
    EXPECT_TRUE(readDisplay(kMirror, "a").isIpdGiven);
    const Display display = readDisplay(
        replaced("\"ipd_m\": 0.062", "\"accuracy_mm\": 1.5, \"accuracy_deg\": 0.5"), "a");
    EXPECT_FALSE(display.isIpdGiven);
    EXPECT_EQ(display.accuracy_m, 1.5e-3);
    EXPECT_NEAR(*display.accuracy_rad, 0.0087266, 1e-6);
    EXPECT_EQ(errorOf(replaced("\"ipd_m\": 0.062", "\"accuracy_mm\": -1")),
              "a: accuracy_mm is -1; it must be 0 .. 1000 mm");
}

TEST(DisplayFile, SaysWhichCornersAreSwapped)
{
    Display display = displays::window();
    std::swap(display.lowerLeft, display.lowerRight);
    try
    {
        checkDisplay(display, "a");
        FAIL();
    }
    catch (const base::InputError& error)
    {
        EXPECT_EQ(std::string(error.what()),
                  "a: screen corners are no rectangle within 1 %: at lowerLeft_m is an angle of "
                  "30.0 degrees: lowerLeft_m and lowerRight_m are swapped");
    }
    display = displays::window();
    display.upperLeft.y() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(checkDisplay(display, "a"), base::InputError);
    display = displays::halfMirror();
    display.optics[0].normal.x() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(checkDisplay(display, "a"), base::InputError);
    display = displays::window();
    display.ipd_m = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(checkDisplay(display, "a"), base::InputError);
}

} // namespace midair::bridge
