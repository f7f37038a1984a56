// Runs the built midair-sense as a user would.
#include "haptics/base/text/Words.h"
#include "tests/samples/Shell.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace
{

const std::string kFolder = MIDAIR_TEST_DATA "/sensations/";

Outcome sense(const std::string& arguments)
{
    return shell(MIDAIR_BIN "/midair-sense " + arguments);
}

std::vector<std::vector<double>> numbersOf(const std::string& text)
{
    std::istringstream lines(text);
    std::vector<std::vector<double>> rows;
    std::string line;
    for (std::getline(lines, line); std::getline(lines, line);)
    {
        rows.emplace_back();
        for (const std::string& cell : midair::base::splitAt(line, ','))
            rows.back().push_back(std::strtod(cell.c_str(), nullptr));
    }
    return rows;
}

std::string textOf(const std::string& path)
{
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
}

} // namespace

TEST(Sense, WritesTheExpectedSamples)
{
    const Outcome written =
        sense(kFolder + "loop.adaptics --conformance --csv - --duration 0.199 --rate 1000");
    ASSERT_EQ(written.code, 0) << written.output;
    EXPECT_EQ(written.output.substr(0, written.output.find('\n')),
              "t_ms,x_mm,y_mm,z_mm,intensity,pattern_time_ms,stop");
    const auto rows = numbersOf(written.output);
    const auto expected = numbersOf(textOf(kFolder + "loop.csv"));
    ASSERT_EQ(rows.size(), expected.size());
    for (std::size_t k = 0; k < rows.size(); ++k)
        for (std::size_t column = 0; column < 7; ++column)
            ASSERT_NEAR(rows[k].at(column), expected[k].at(column), 1e-6) << k << " " << column;
}

TEST(Sense, PrintsFigures)
{
    const Outcome circle = sense("'circle?radius=10mm' --rate 500 --device usb:");
    ASSERT_EQ(circle.code, 0) << circle.output;
    EXPECT_NE(circle.output.find("extent      x -10.0 .. 10.0, y -10.0 .. 10.0"), std::string::npos)
        << circle.output;
    EXPECT_NE(circle.output.find("never stops"), std::string::npos);
    EXPECT_NE(circle.output.find("4.40 m/s"), std::string::npos);
    EXPECT_NE(circle.output.find("7.1 points a turn at 500 fields/s, too few"), std::string::npos);
    EXPECT_NE(sense("click").output.find("duration    100.0 ms"), std::string::npos);
    EXPECT_NE(sense("--list").output.find("heartbeat:"), std::string::npos);
}

TEST(Sense, SaysWhatADeviceMakesOfIt)
{
    const std::string mega = " --array ultraino64 --device ";
    const auto says = [](const std::string& arguments, const std::string& text)
    {
        const Outcome outcome = sense(arguments);
        EXPECT_EQ(outcome.code, 0) << outcome.output;
        EXPECT_NE(outcome.output.find(text), std::string::npos) << outcome.output;
    };
    says("circle" + mega + "sim:?board=ultraino",
         "device      sim:?board=ultraino repeats 11 fields by itself: 69.93 turns a second");
    says("circle" + mega + "ultraino:/dev/none", "ultraino:/dev/none repeats 11 fields by itself");
    says("circle" + mega + "'ultraino:/dev/none?ramp=20ms'",
         "?ramp=20ms takes 57.3 fields a second: the brush is an outline");
    says("pulse" + mega + "sim:?board=ultraino", "fields a second: the brush is an outline");
    const std::string surface = " --array sonicsurface --device sonicsurface:/dev/none";
    says("point-am" + surface,
         " repeats 2 fields by itself: a modulation of 143 Hz, of the brush's outline");
    says("circle" + surface, "fields a second: the brush is an outline");
    says("circle", "device      sim: plays every field");
    says("circle --device usb:", "device      usb: says what it takes when it is open");
    // A device that can't exist is an error, and too few points are one of what is played live.
    for (const std::string device : {"nosuch:", "'sim:?max-amplitude=3'"})
    {
        const Outcome refused = sense("circle --device " + device);
        EXPECT_EQ(refused.code, 2) << refused.output;
        EXPECT_NE(refused.output.find("device \""), std::string::npos) << refused.output;
    }
    const Outcome stored = sense("circle --rate 100" + mega + "sim:?board=ultraino");
    EXPECT_EQ(stored.output.find("too few"), std::string::npos) << stored.output;
}

TEST(Sense, SetsParametersWhenTheyAreDue)
{
    const std::string folder = testing::TempDir() + "midair-sense-set";
    std::filesystem::create_directories(folder);
    std::ofstream(folder + "/set.csv") << "t_ms,name,value\n5,radius,30\n";
    const Outcome written = sense("'circle?frequency=0' --set radius=10 --params " + folder +
                                  "/set.csv --duration 0.01 --csv " + folder + "/out.csv");
    ASSERT_EQ(written.code, 0) << written.output;
    const auto rows = numbersOf(textOf(folder + "/out.csv"));
    ASSERT_EQ(rows.size(), 11U);
    EXPECT_DOUBLE_EQ(rows[4].at(1), 10.0);
    EXPECT_DOUBLE_EQ(rows[5].at(1), 30.0);
    std::filesystem::remove_all(folder);
}

TEST(Sense, DrawsAPicture)
{
    const std::string file = testing::TempDir() + "midair-sense.svg";
    const Outcome drawn = sense("heartbeat --duration 2 --picture " + file);
    ASSERT_EQ(drawn.code, 0) << drawn.output;
    EXPECT_NE(textOf(file).find("frequency (Hz)"), std::string::npos);
    std::filesystem::remove(file);
}

TEST(Sense, PlaysOnADevice)
{
    const Outcome clicked = sense("click --play --array board --pressure 2000");
    EXPECT_EQ(clicked.code, 0) << clicked.output;
    EXPECT_NE(clicked.output.find("plays on board by sim:, up to 2000 Pa; the pattern's origin is "
                                  "at (0.000, 0.000, 0.200) m"),
              std::string::npos)
        << clicked.output;
    const Outcome timed = sense("circle --play --set radius=10 --seconds 0.1");
    EXPECT_EQ(timed.code, 0) << timed.output;
    const Outcome failed = sense("circle --play --device record:/nowhere/file.hfr");
    EXPECT_EQ(failed.code, 3) << failed.output;
    EXPECT_NE(failed.output.find("/nowhere/file.hfr"), std::string::npos) << failed.output;
}

TEST(Sense, ServesUntilItIsEnded)
{
    const std::string out = testing::TempDir() + "midair-sense-served.txt";
    const Outcome served =
        shell("out=" + out +
              "; " MIDAIR_BIN "/midair-sense --serve --array board --port 0 > $out & "
              "for i in $(seq 600); do grep -q ws://127.0.0.1: $out && break; sleep 0.1; done; "
              "kill -TERM $!; wait $!; code=$?; cat $out; rm $out; exit $code");
    EXPECT_EQ(served.code, 0) << served.output;
    EXPECT_NE(served.output.find("plays on board by sim:, up to 3000 Pa"), std::string::npos)
        << served.output;
    EXPECT_NE(served.output.find("fields played"), std::string::npos) << served.output;
}

TEST(Sense, RefusesWhatItCannotRead)
{
    const std::vector<std::pair<std::string, std::string>> wrong = {
        {"", "name an .adaptics file"},
        {"circel", "did you mean circle?"},
        {"'circle?radius=1kg'", "within 0 .. 200 mm"},
        {"circle --set radios=1", "did you mean radius?"},
        {"circle --set radius", "should be NAME=VALUE"},
        {"circle --params /nowhere.csv", "/nowhere.csv"},
        {"circle --csv /nowhere/out.csv", "can't be written"},
        {"circel --play", "did you mean circle?"},
        {"circle --play --set radios=1", "did you mean radius?"},
        {"circle --play --array nosuch", "array 'nosuch'"},
        {"circle --serve", "the Designer sends it"},
        {"--serve --origin example.org", "should be https://HOST"}};
    for (const auto& [arguments, message] : wrong)
    {
        const Outcome refused = sense(arguments);
        EXPECT_EQ(refused.code, 2) << arguments;
        EXPECT_NE(refused.output.find("midair-sense: "), std::string::npos) << refused.output;
        EXPECT_NE(refused.output.find(message), std::string::npos) << refused.output;
    }
}
