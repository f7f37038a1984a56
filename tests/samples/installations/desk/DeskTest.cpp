#include "tests/samples/installations/Run.h"

#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

TEST(Desk, TheDeskPlaysOnTheArrayOfItsDevice)
{
    const OwnFolder out("desk");
    for (const auto& [device, array, transducers] :
         // A busy machine may keep units waiting for longer than 100 ms.
         {std::tuple<const char*, const char*, int>{
              "sim:?board=autd3&units=1&failsafe=5s", "autd3", 249},
          {"sim:?board=sonicsurface", "sonicsurface", 256}})
    {
        const Visit run = visit("desk", std::string("--frames 400 --device '") + device + "'", out);
        ASSERT_EQ(run.outcome.code, 0) << run.outcome.output;
        expectQuiet(run.report);
        EXPECT_EQ(run.report.at("array"), array);
        EXPECT_EQ(run.report.at("transducers"), transducers);
        EXPECT_GT(run.report.at("fields").at("played"), 20) << run.outcome.output;
        EXPECT_GT(run.report.at("scene").at("pointsAtMost"), 5);
        EXPECT_GT(run.report.at("scene").at("presses").at("quick"), 0);
        EXPECT_GT(run.report.at("scene").at("presses").at("trembling"), 0);
    }
}

TEST(Desk, AMutedDeskIsSilent)
{
    const OwnFolder out("muted");
    const Visit run = visit("desk", "--frames 200 --muted", out);
    ASSERT_EQ(run.outcome.code, 0) << run.outcome.output;
    EXPECT_EQ(run.report.at("silence").at("framesMuted"), 200);
    EXPECT_EQ(run.report.at("silence").at("playedMuted"), 0);
    EXPECT_EQ(run.report.at("framesPlaying"), 0);
    EXPECT_EQ(run.report.at("state"), "muted");
}

TEST(Desk, NobodyThereIsSilence)
{
    const OwnFolder out("alone");
    const Visit run = visit("desk", "--frames 520 --linger 0.5", out);
    ASSERT_EQ(run.outcome.code, 0) << run.outcome.output;
    expectQuiet(run.report);
    EXPECT_GT(run.report.at("framesPlaying"), 100);
    EXPECT_GT(run.report.at("silence").at("framesAlone"), 60);
}

TEST(Desk, SayWhatIsWrong)
{
    const OwnFolder out("wrong");
    const std::vector<std::pair<std::string, std::string>> kWrong = {
        {"--window 10x10", "--window: is \"10x10\", should be WIDTHxHEIGHT in pixels"},
        {"--set loudness", "--set: is \"loudness\", should be NAME=VALUE"},
        {"--set maxPressure=loud", "maxPressure is \"loud\""},
        {"--frames 0", "--frames"},
    };
    for (const auto& [arguments, text] : kWrong)
    {
        const Visit run = visit("desk", arguments, out);
        EXPECT_NE(run.outcome.code, 0) << arguments;
        EXPECT_NE(run.outcome.output.find(text), std::string::npos) << run.outcome.output;
    }
    EXPECT_EQ(visit("desk", "--help", out).outcome.code, 0);
}
