// Runs midair-display as a user would, with recordings in the place of people.

#include "haptics/array/TransducerArray.h"
#include "haptics/boards/BoardMeasurements.h"
#include "tests/engine-bridge/display/LightTracer.h"
#include "tests/engine-bridge/tags/TagSimulation.h"
#include "tests/samples/Shell.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace
{

const std::string kTool = MIDAIR_BIN "/midair-display";
const std::string kMirrorFile = MIDAIR_ROOT "/samples/displays/mirror.display.json";

using Place = std::array<double, 3>;

std::string inTemporary(const std::string& name)
{
    return testing::TempDir() + "midair-display-" + name;
}

std::string readAll(const std::string& path)
{
    std::ifstream in(path);
    std::stringstream text;
    text << in.rdbuf();
    return text.str();
}

/// Where cross \a k of the mirror's file is seen, 5 mm higher and 3 mm to the right of where the
/// file says. Its mirror, z - y = 0.25 m, exchanges the screen's depth and height, so that the
/// picture stands upright: x from 0.266 to -0.266 m, z from -0.15 to 0.15 m.
Place seenCross(int k)
{
    const double u = 0.1 + 0.8 / 3.0 * (k % 4);
    const int row = k / 4;
    const double v = 0.85 - 0.35 * row;
    return {0.266 - 0.532 * u + 0.003, 0.0, -0.15 + 0.3 * v + 0.005};
}

/// A recording of a right index finger that is held at each of \a places for 1.6 s, with a jitter
/// of a millimetre.
void recordHands(const std::string& path, const std::vector<Place>& places)
{
    std::mt19937_64 random(3);
    std::normal_distribution<double> jitter(0.0, 1e-3);
    std::ofstream out(path);
    out << "time_s,hand,joint,x,y,z,qx,qy,qz,qw,radius_m,position_valid,orientation_valid\n";
    double time_s = 0.0;
    for (const Place& place : places)
        for (int i = 0; i < 32; ++i, time_s += 0.05)
        {
            out << time_s << ",1,index_tip";
            for (const double value : place)
                out << "," << value + jitter(random);
            out << ",0,0,0,1,0.008,1,1\n";
        }
}

std::string touchesFile(const std::string& name, double noise_m, int count = 12)
{
    std::mt19937_64 random(4);
    std::normal_distribution<double> noise(0.0, noise_m);
    const std::string path = inTemporary(name);
    std::ofstream out(path);
    for (int k = 0; k < count; ++k)
    {
        out << k + 1;
        for (const double value : seenCross(k))
            out << "," << value + noise(random);
        out << "\n";
    }
    return path;
}

nlohmann::json cornersOf(const std::string& path)
{
    return nlohmann::json::parse(readAll(path))["screen"];
}

} // namespace

TEST(DisplayTool, CalibratesAMirrorByTouches)
{
    const std::string out = inTemporary("touched.json");
    const Outcome outcome = shell(kTool + " calibrate " + kMirrorFile + " --touches " +
                                  touchesFile("touches.csv", 0.5e-3) + " --out " + out);
    EXPECT_EQ(outcome.code, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("calibrated from 12 of 12 touched crosses\nresiduals: rms "),
              std::string::npos)
        << outcome.output;
    EXPECT_NE(outcome.output.find("likely error at the workspace's edge, 100 mm from the picture's "
                                  "middle: "),
              std::string::npos)
        << outcome.output;
    // 5 mm up in the picture are 5 mm back on the screen, 3 mm aside stay what they are.
    const auto corner = cornersOf(out)["lowerLeft_m"];
    EXPECT_NEAR(corner[0].get<double>(), 0.269, 1e-3);
    EXPECT_NEAR(corner[1].get<double>(), -0.395, 1e-3);
    EXPECT_NEAR(corner[2].get<double>(), 0.25, 1e-3);
    EXPECT_NE(readAll(out).find("\"half-mirror\""), std::string::npos);
}

TEST(DisplayTool, TakesTouchesFromAHandThatIsHeldStill)
{
    std::vector<Place> places;
    for (int k = 0; k < 12; ++k)
        places.push_back(seenCross(k));
    const std::string hands = inTemporary("hands.csv");
    const std::string out = inTemporary("held.json");
    const std::string saved = inTemporary("saved.csv");
    recordHands(hands, places);
    const Outcome outcome = shell(kTool + " calibrate " + kMirrorFile + " --headless --hands " +
                                  hands + " --save " + saved + " --out " + out);
    EXPECT_EQ(outcome.code, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("cross 12: "), std::string::npos) << outcome.output;
    EXPECT_NEAR(cornersOf(out)["lowerLeft_m"][1].get<double>(), -0.395, 0.5e-3);
    // What was touched is fitted again to the same.
    const std::string again = inTemporary("again.json");
    EXPECT_EQ(
        shell(kTool + " calibrate " + kMirrorFile + " --touches " + saved + " --out " + again).code,
        0);
    EXPECT_NEAR(cornersOf(again)["upperLeft_m"][1].get<double>(),
                cornersOf(out)["upperLeft_m"][1].get<double>(),
                2e-5);

    places.resize(5);
    recordHands(hands, places);
    const Outcome ended = shell(kTool + " calibrate " + kMirrorFile + " --headless --hands " +
                                hands + " --out " + out);
    EXPECT_EQ(ended.code, 2);
    EXPECT_NE(ended.output.find("midair-display: the hands ended after 5 of 12 touches; nothing is "
                                "written\n"),
              std::string::npos)
        << ended.output;
}

TEST(DisplayTool, WritesNothingOfWhatIsNotUsable)
{
    const std::string out = inTemporary("none.json");
    std::remove(out.c_str());
    const std::string begin = kTool + " calibrate " + kMirrorFile + " --out " + out + " --touches ";
    const Outcome noisy = shell(begin + touchesFile("noisy.csv", 25e-3));
    EXPECT_EQ(noisy.code, 1) << noisy.output;
    EXPECT_NE(noisy.output.find("is over 5.0 mm"), std::string::npos) << noisy.output;
    const Outcome line = shell(begin + touchesFile("line.csv", 1e-3, 4));
    EXPECT_EQ(line.code, 1) << line.output;
    EXPECT_NE(line.output.find("not usable: the crosses lie on one line"), std::string::npos)
        << line.output;
    // All crosses covered from one place of the head.
    const std::string sights = inTemporary("sights.csv");
    {
        std::ofstream file(sights);
        for (int k = 0; k < 12; ++k)
        {
            const Place cross = seenCross(k);
            file << k + 1 << "," << 0.5 * cross[0] << "," << 0.5 * (cross[1] - 0.85) << ","
                 << 0.5 * (cross[2] + 0.17) << ",-0.0315,-0.85,0.17,0.7071,0,0,0.7071\n";
        }
    }
    const Outcome one = shell(begin + sights + " --sight");
    EXPECT_EQ(one.code, 1) << one.output;
    EXPECT_NE(one.output.find("not usable: the head was at one place"), std::string::npos)
        << one.output;
    EXPECT_FALSE(std::ifstream(out).good());
}

// A headset's world is turned by 90 degrees about z and moved against the array.
TEST(DisplayTool, FindsTheArrayForAHeadset)
{
    const std::string places = inTemporary("places.txt");
    std::vector<Place> touched;
    {
        std::ofstream file(places);
        const double known[][3] = {{0.1, 0.0, 0.0},
                                   {-0.1, 0.0, 0.0},
                                   {0.0, 0.1, 0.0},
                                   {0.0, -0.1, 0.02},
                                   {0.0, 0.0, 0.15},
                                   {0.1, 0.1, 0.1}};
        for (int k = 0; k < 6; ++k)
        {
            file << "place P" << k << " " << known[k][0] << " " << known[k][1] << " " << known[k][2]
                 << "\n";
            touched.push_back({-known[k][1] + 0.4, known[k][0] + 1.0, known[k][2] - 0.2});
        }
    }
    std::vector<Place> twice = touched;
    twice.insert(twice.end(), touched.begin(), touched.end());
    const std::string hands = inTemporary("headset.csv");
    const std::string matrix = inTemporary("matrix.txt");
    recordHands(hands, twice);
    const Outcome outcome = shell(kTool + " calibrate openxr: --headless --rounds 2 --hands " +
                                  hands + " --places " + places + " --matrix " + matrix);
    EXPECT_EQ(outcome.code, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("calibrated from 12 of 12 point pairs"), std::string::npos)
        << outcome.output;
    std::ifstream in(matrix);
    std::string comment;
    std::getline(in, comment);
    std::array<double, 16> numbers{};
    for (double& number : numbers)
        in >> number;
    // array = world * M: x_a = y_w - 1, y_a = -x_w + 0.4, z_a = z_w + 0.2.
    EXPECT_NEAR(numbers[4], 1.0, 0.01);
    EXPECT_NEAR(numbers[1], -1.0, 0.01);
    EXPECT_NEAR(numbers[12], -1.0, 2e-3);
    EXPECT_NEAR(numbers[13], 0.4, 2e-3);
    EXPECT_NEAR(numbers[14], 0.2, 2e-3);
}

TEST(DisplayTool, ChecksByCrossesOnTheArraysCorners)
{
    const std::string out = inTemporary("check.ppm");
    const std::string calibration = "1 0 0 0  0 1 0 0  0 0 1 0  0 0 0.15 1";
    const Outcome outcome =
        shell(kTool + " check " + kMirrorFile + " --array board --calibration \"" + calibration +
              "\" --out " + out);
    ASSERT_EQ(outcome.code, 0) << outcome.output;
    std::ifstream in(out, std::ios::binary);
    std::string kind;
    int width = 0, height = 0, most = 0;
    in >> kind >> width >> height >> most;
    in.get();
    ASSERT_EQ(width, 1920);
    std::vector<unsigned char> pixels(static_cast<std::size_t>(3) * 1920 * 1080);
    in.read(reinterpret_cast<char*>(pixels.data()), static_cast<std::streamsize>(pixels.size()));
    // By light that is traced from the eye; x is turned on the screen, and rows go down in the
    // file.
    const LightTracer tracer(midair::bridge::loadDisplay(kMirrorFile));
    const auto array = midair::haptics::TransducerArray::load("board");
    const midair::haptics::BoardMarks marks(array);
    int seen = 0;
    for (const char letter : {'a', 'b', 'c', 'd'})
    {
        const Eigen::Vector3d corner =
            array.positions.col(marks.corner(0, letter)) - 0.15 * Eigen::Vector3d::UnitZ();
        const auto at = tracer.pixel({0.0, -0.85, 0.17}, corner);
        if (!at) continue;
        ++seen;
        int brightest = 0;
        for (int dx = -1; dx <= 1; ++dx)
            for (int dy = -1; dy <= 1; ++dy)
            {
                const int x = static_cast<int>(at->x()) + dx;
                const int y = 1079 - static_cast<int>(at->y()) + dy;
                brightest =
                    std::max<int>(brightest, pixels[static_cast<std::size_t>(3 * (1920 * y + x))]);
            }
        EXPECT_GT(brightest, 100) << "corner " << letter;
    }
    EXPECT_EQ(seen, 2);
    const Outcome wrong =
        shell(kTool + " check " + kMirrorFile + " --calibration \"1 2 3\" --out " + out);
    EXPECT_EQ(wrong.code, 2);
    EXPECT_NE(wrong.output.find("--calibration should be the sixteen numbers of a matrix"),
              std::string::npos);
}

// Photos of a screen that is 4 mm farther back than the file says, through its mirror.
TEST(DisplayTool, CalibratesByACameraThatSeesTags)
{
    const midair::bridge::Display file = midair::bridge::loadDisplay(kMirrorFile);
    midair::bridge::Display truth = file;
    for (Eigen::Vector3d* corner : {&truth.lowerLeft, &truth.lowerRight, &truth.upperLeft})
        corner->y() += 0.004;
    midair::bridge::TagRig rig = TagSimulation::rig();
    nlohmann::json json = {{"camera",
                            {{"pixels", {rig.camera.width, rig.camera.height}},
                             {"focal_px", {rig.camera.fx, rig.camera.fy}}}}};
    for (midair::bridge::PlacedTag& tag : rig.tags)
    {
        tag.middle.z() += 0.3; // above the picture
        json["tags"].push_back({{"id", tag.id},
                                {"size_m", tag.size_m},
                                {"middle_m", {tag.middle.x(), tag.middle.y(), tag.middle.z()}},
                                {"right", {tag.right.x(), tag.right.y(), tag.right.z()}},
                                {"up", {tag.up.x(), tag.up.y(), tag.up.z()}}});
    }
    TagSimulation simulation(truth, rig, midair::bridge::shownTags(file), 3);
    for (int k = 0; k < 4; ++k)
    {
        const midair::bridge::GrayImage image = simulation.photo(simulation.camera(0.1));
        const std::string name = "photo" + std::to_string(k) + ".pgm";
        std::ofstream out(inTemporary(name), std::ios::binary);
        out << "P5 " << image.width << " " << image.height << " 255\n";
        out.write(reinterpret_cast<const char*>(image.pixels.data()),
                  static_cast<std::streamsize>(image.pixels.size()));
        json["camera"]["images"].push_back("midair-display-" + name);
    }
    const std::string rigFile = inTemporary("rig.json");
    std::ofstream(rigFile) << json.dump();
    const std::string out = inTemporary("tags.json");
    const Outcome outcome =
        shell(kTool + " calibrate " + kMirrorFile + " --tags " + rigFile + " --out " + out);
    EXPECT_EQ(outcome.code, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("calibrated from 4 of 4 photos\n"), std::string::npos)
        << outcome.output;
    const auto corner = cornersOf(out)["lowerLeft_m"];
    EXPECT_NEAR(corner[0].get<double>(), truth.lowerLeft.x(), 2e-3);
    EXPECT_NEAR(corner[1].get<double>(), truth.lowerLeft.y(), 2e-3);
    EXPECT_NEAR(corner[2].get<double>(), truth.lowerLeft.z(), 2e-3);
}
