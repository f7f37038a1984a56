// AdapTics' protocol, message by message, at times that the tests set.
#include "samples/tools/sense/DesignerSession.h"

#include "haptics/sensation/SensationReader.h"
#include "tests/samples/tools/sense/FakeOutput.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

using namespace midair::samples;
using nlohmann::json;

namespace
{

class DesignerSessions : public testing::Test
{
protected:
    std::string take(const std::string& message, double now_s = 0.0)
    {
        return _session.take(message, now_s);
    }
    /// Returns the samples of the update at \a now_s; null: there is none.
    json evals(double now_s)
    {
        const std::string text = _session.update(now_s);
        if (text.empty()) return nullptr;
        const json message = json::parse(text);
        EXPECT_EQ(message["cmd"], "playback_update");
        return message["data"]["evals"];
    }
    static double x(const json& eval) { return eval["ul_control_point"]["coords"]["x"]; }
    static double intensity(const json& eval) { return eval["ul_control_point"]["intensity"]; }
    /// As the Designer does when it has connected and then plays from \a time_ms on.
    void play(double time_ms = 0.0, double now_s = 0.0)
    {
        EXPECT_EQ(take(stopMessage()), "");
        EXPECT_EQ(take(updatePattern(pattern())), "");
        EXPECT_EQ(take(updateParameters(json::object(), time_ms)), "");
        EXPECT_EQ(take(command("update_tracking", {{"enabled", false}})), "");
        EXPECT_EQ(take(updatePlaystart(time_ms), now_s), "");
    }

    FakeOutput _output;
    std::vector<std::string> _told;
    DesignerSession _session{_output, [this](const std::string& what) { _told.push_back(what); }};
};

} // namespace

TEST_F(DesignerSessions, PlaysAndTellsWhatIsPlayed)
{
    EXPECT_EQ(_session.update(0.0), "");
    play(0.0, 100.0);
    EXPECT_TRUE(_output.isPlaying);
    EXPECT_EQ(_output.sensation, pattern().dump());
    EXPECT_EQ(_output.parameters, "strength=0.5");
    const json first = evals(100.0);
    ASSERT_EQ(first.size(), 1U);
    const json expected = {
        {"ul_control_point",
         {{"coords", {{"x", 0.0}, {"y", 0.0}, {"z", 200.0}}}, {"intensity", 0.5}}},
        {"pattern_time", 0.0},
        {"stop", false},
        {"next_eval_params", {{"last_eval_pattern_time", 0.0}, {"time_offset", 0.0}}}};
    EXPECT_EQ(first[0], expected);
    const json more = evals(100.0 + 1.0 / 60.0);
    ASSERT_EQ(more.size(), 16U) << "one a ms";
    EXPECT_DOUBLE_EQ(x(more[0]), 1.0);
    EXPECT_DOUBLE_EQ(x(more[15]), 16.0);
    EXPECT_EQ(more[15]["pattern_time"], 16.0);
    EXPECT_EQ(more[15]["next_eval_params"]["last_eval_pattern_time"], 16.0);
    EXPECT_EQ(_session.update(100.0 + 1.0 / 60.0), "") << "nothing is new";
    EXPECT_EQ(evals(100.5).size(), DesignerSession::kMostSamples) << "after a pause";
    EXPECT_TRUE(_told.empty()) << _told[0];
}

TEST_F(DesignerSessions, StopsWithThePattern)
{
    play();
    evals(0.995);
    const json end = evals(1.005);
    EXPECT_FALSE(end.front()["stop"].get<bool>());
    EXPECT_TRUE(end.back()["stop"].get<bool>());
    EXPECT_TRUE(_session.isPlaying()) << "the Designer looks at the first sample";
    EXPECT_TRUE(evals(1.02).front()["stop"].get<bool>());
    EXPECT_FALSE(_session.isPlaying());
    EXPECT_FALSE(_output.isPlaying);
    EXPECT_EQ(_session.update(1.04), "");
    EXPECT_EQ(take(stopMessage(), 1.05), "");
    EXPECT_EQ(_session.update(1.06), "");
}

TEST_F(DesignerSessions, StopsAtOnceWhenItIsAsked)
{
    play();
    evals(0.1);
    EXPECT_EQ(take(stopMessage(), 0.11), "");
    EXPECT_FALSE(_output.isPlaying);
    EXPECT_EQ(_session.update(0.12), "") << "the Designer knows";
}

TEST_F(DesignerSessions, BeginsInTheMiddle)
{
    play(300.0);
    EXPECT_NE(_output.sensation, pattern().dump());
    EXPECT_EQ(json::parse(_output.sensation)["keyframes"][1]["time"], 700.0);
    const json first = evals(0.01);
    EXPECT_DOUBLE_EQ(x(first[0]), 300.0);
    EXPECT_EQ(first[10]["pattern_time"], 310.0);
    EXPECT_EQ(take(stopMessage()), "");
    // The Designer's message takes some ms; another program may mean another time.
    EXPECT_EQ(take(command("update_playstart", {{"playstart", 1}, {"playstart_offset", -303.0}})),
              "");
    EXPECT_DOUBLE_EQ(x(evals(0.0)[0]), 300.0);
    EXPECT_EQ(take(command("update_playstart", {{"playstart", 1}, {"playstart_offset", -500.0}})),
              "");
    EXPECT_DOUBLE_EQ(x(evals(0.0)[0]), 500.0);
}

TEST_F(DesignerSessions, JumpsMoveWithTheBeginning)
{
    json looped = pattern();
    looped["keyframes"][1]["cjumps"] = {
        {{"condition",
          {{"parameter", "strength"},
           {"operator", {{"name", "gt"}, {"params", json::object()}}},
           {"value", 0.0}}},
         {"jump_to", 200}}};
    EXPECT_EQ(take(updatePattern(looped)), "");
    EXPECT_EQ(take(updateParameters(json::object(), 900.0)), "");
    EXPECT_EQ(take(updatePlaystart(900.0)), "");
    EXPECT_EQ(json::parse(_output.sensation)["keyframes"][1]["cjumps"][0]["jump_to"], -700.0);
    const json all = evals(0.15);
    EXPECT_NEAR(all.back()["pattern_time"].get<double>(), 250.0, 0.1);
    EXPECT_NEAR(all.back()["next_eval_params"]["time_offset"].get<double>(), -800.0, 0.1)
        << "of a time that begins at 900 ms";
}

TEST_F(DesignerSessions, APatternThatChangesWhilePlayingKeepsItsTime)
{
    play();
    evals(0.25);
    EXPECT_EQ(take(updatePattern(pattern(2000.0, 7.0)), 0.3), "");
    EXPECT_TRUE(_output.isPlaying);
    EXPECT_EQ(_output.sensation, pattern(2000.0, 7.0).dump());
    const json all = evals(0.31);
    EXPECT_DOUBLE_EQ(x(all.back()), 310.0);
    EXPECT_EQ(all.back()["ul_control_point"]["coords"]["y"], 7.0);
    EXPECT_EQ(all[0]["ul_control_point"]["coords"]["y"], 0.0) << "as it was played";
    EXPECT_EQ(std::count(_output.calls.begin(), _output.calls.end(), "begin"), 1);
}

TEST_F(DesignerSessions, FollowsParameters)
{
    play();
    EXPECT_EQ(take(updateParameters({{"strength", 0.25}, {"unused", 3}}), 0.01), "");
    EXPECT_EQ(_output.parameters, "strength=0.25") << "what the pattern has";
    EXPECT_DOUBLE_EQ(intensity(evals(0.02).back()), 0.25);
    EXPECT_EQ(take(command("user_parameter", {{"name", "strength"}, {"value", 0.75}}), 0.03), "");
    EXPECT_DOUBLE_EQ(intensity(evals(0.04).back()), 0.75);
    EXPECT_EQ(take(command("user_parameters", {{"user_parameters", {{"strength", 9}}}}), 0.05), "");
    EXPECT_EQ(_output.parameters, "strength=1") << "within its range";
    EXPECT_EQ(take(updateParameters(json::object()), 0.06), "");
    EXPECT_EQ(_output.parameters, "strength=0.5") << "its own again";
    // They are those of the next pattern, too.
    EXPECT_EQ(take(updateParameters({{"strength", 0.125}}), 0.07), "");
    EXPECT_EQ(take(updatePattern(pattern(500.0)), 0.08), "");
    EXPECT_EQ(_output.parameters, "strength=0.125");
}

TEST_F(DesignerSessions, FollowsTransformAndTracking)
{
    play();
    const json turned = {{0, -1, 0, 10}, {1, 0, 0, 20}, {0, 0, 1, 30}, {0, 0, 0, 1}};
    EXPECT_EQ(take(command("geo_transform_matrix", {{"transform", turned}}), 0.1), "");
    EXPECT_NEAR(_output.transform(2, 3), 0.030, 1e-12) << "m";
    EXPECT_DOUBLE_EQ(_output.transform(0, 1), -1.0);
    const json at = evals(0.1).back()["ul_control_point"]["coords"];
    EXPECT_NEAR(at["x"].get<double>(), 10.0, 1e-9);
    EXPECT_NEAR(at["y"].get<double>(), 120.0, 1e-9);
    EXPECT_NEAR(at["z"].get<double>(), 230.0, 1e-9);
    EXPECT_EQ(take(command("update_tracking", {{"enabled", true}}), 0.1), "");
    EXPECT_TRUE(_output.isTracking);
    EXPECT_EQ(take(command("parameter_time", {{"time", 5.0}}), 0.1), "");
    // A scale isn't one of an array's places.
    const json scaled = {{2, 0, 0, 0}, {0, 2, 0, 0}, {0, 0, 2, 0}, {0, 0, 0, 1}};
    const std::string refused = take(command("geo_transform_matrix", {{"transform", scaled}}), 0.1);
    EXPECT_NE(refused.find("has a scale"), std::string::npos) << refused;
    EXPECT_NEAR(_output.transform(2, 3), 0.030, 1e-12);
    EXPECT_TRUE(_output.isPlaying);
    _session.reset();
    EXPECT_FALSE(_output.isTracking);
    EXPECT_TRUE(_output.transform.isIdentity());
}

TEST_F(DesignerSessions, TellsTheHandAsLongAsThereIsOne)
{
    EXPECT_EQ(_session.tracking(), "");
    _output.shownHand = handAbove(0.15);
    for (int update = 0; update < 2; ++update)
    {
        const json frame = trackingFrameIn(_session.tracking());
        ASSERT_TRUE(frame["hand"].is_object());
        EXPECT_EQ(frame["hand"]["chirality"], "Right");
    }
    _output.shownHand.reset();
    EXPECT_TRUE(trackingFrameIn(_session.tracking())["hand"].is_null());
    EXPECT_EQ(_session.tracking(), "") << "once";
    _output.shownHand = handAbove(0.15);
    EXPECT_NE(_session.tracking(), "");
    _session.reset();
    _output.shownHand.reset();
    EXPECT_EQ(_session.tracking(), "") << "another client was told of no hand";
}

TEST_F(DesignerSessions, AHandHasAPalmAndTheBonesOfItsDigits)
{
    SenseHand hand = handAbove(0.15);
    const json right = trackingFrameIn(trackingData(hand))["hand"];
    const json& palm = right["palm"];
    EXPECT_EQ(numbersOf(palm["position"]), (std::vector<double>{0.0, 0.0, 150.0}));
    EXPECT_EQ(numbersOf(palm["direction"]), (std::vector<double>{0.0, 1.0, 0.0}));
    EXPECT_EQ(numbersOf(palm["normal"]), (std::vector<double>{0.0, 0.0, -1.0}))
        << "the palm looks at the array";
    EXPECT_NEAR(palm["width"].get<double>(), 60.0 + 2 * 8.0, 1e-9) << "over four knuckles";
    // Each bone begins where the one before it ends.
    for (std::size_t digit = 0; digit < 5; ++digit)
    {
        const json& bones = right["digits"][digit]["bones"];
        for (std::size_t bone = 0; bone + 1 < 4; ++bone)
            EXPECT_EQ(bones[bone]["end"], bones[bone + 1]["start"]) << digit << ' ' << bone;
        EXPECT_NEAR(numbersOf(bones[3]["end"])[0], -40.0 + 20.0 * static_cast<double>(digit), 1e-9)
            << "the tip of digit " << digit;
        EXPECT_NEAR(bones[1]["width"].get<double>(), 16.0, 1e-9);
    }
    EXPECT_EQ(right["digits"][0]["bones"][0]["start"], right["digits"][0]["bones"][0]["end"])
        << "a thumb has no bone in the palm";
    hand.isLeft = true;
    EXPECT_EQ(trackingFrameIn(trackingData(hand))["hand"]["chirality"], "Left");
}

TEST_F(DesignerSessions, RefusesABrokenPatternAndIsSilent)
{
    play();
    evals(0.1);
    json broken = pattern();
    broken["keyframes"][0].erase("cjumps");
    const std::string answer = take(updatePattern(broken), 0.11);
    EXPECT_EQ(json::parse(answer)["cmd"], "error");
    const std::string message = json::parse(answer)["data"]["message"];
    EXPECT_NE(message.find("the Designer's pattern, line 1: keyframes[0] lacks 'cjumps'"),
              std::string::npos)
        << message;
    ASSERT_EQ(_told.size(), 1U);
    EXPECT_EQ(_told[0], message);
    EXPECT_FALSE(_output.isPlaying);
    const json last = evals(0.12);
    ASSERT_EQ(last.size(), 1U) << "so that the Designer stops, too";
    EXPECT_TRUE(last[0]["stop"].get<bool>());
    EXPECT_EQ(_session.update(0.13), "");
    const std::string none = take(updatePlaystart(0.0), 0.14);
    EXPECT_NE(none.find("there is no pattern to play"), std::string::npos) << none;
    EXPECT_EQ(take(updatePattern(pattern()), 0.15), "");
    EXPECT_EQ(take(updatePlaystart(0.0), 0.16), "");
    EXPECT_TRUE(_output.isPlaying);
}

TEST_F(DesignerSessions, WhatTheOutputRefusesIsTold)
{
    _output.refusal = "the array is on fire";
    EXPECT_EQ(take(updatePattern(pattern())), "");
    const std::string answer = take(updatePlaystart(0.0));
    EXPECT_NE(answer.find("the array is on fire"), std::string::npos) << answer;
    EXPECT_FALSE(_session.isPlaying());
    _output.refusal.clear();
    EXPECT_EQ(take(updatePlaystart(0.0)), "");
    EXPECT_TRUE(_output.isPlaying);
}

TEST_F(DesignerSessions, EndsOnWhatIsNoMessage)
{
    for (const std::string& text :
         {std::string("{"),
          std::string(),
          std::string("[]"),
          std::string("null"),
          std::string("{\"cmd\": 3, \"data\": {}}"),
          std::string("{\"data\": {}}"),
          std::string("{\"cmd\": \"update_playstart\", \"data\": {\"playstart\": \"now\"}}"),
          std::string("{\"cmd\": \"update_playstart\"}"),
          std::string("{\"cmd\": \"update_pattern\", \"data\": {\"pattern_json\": {}}}"),
          std::string("{\"cmd\": \"update_pattern\", \"data\": 1}"),
          std::string("{\"cmd\": \"update_playstart\", \"data\": {\"playstart\": 1e999}}"),
          std::string(200000, '['),
          std::string("\xFF\xFE")})
    {
        play();
        const std::string answer = take(text, 0.1);
        EXPECT_EQ(json::parse(answer)["cmd"], "error") << text.substr(0, 60);
        EXPECT_FALSE(_output.isPlaying) << text.substr(0, 60);
        _session.reset();
    }
}

TEST_F(DesignerSessions, RefusesWhatIsTooLarge)
{
    play();
    const std::string large =
        take(updatePattern(std::string(midair::haptics::kMostSensationBytes, 'x')));
    EXPECT_NE(large.find("at most 4194304 are possible"), std::string::npos) << large;
    EXPECT_FALSE(_output.isPlaying);
    play();
    const std::string larger = take(std::string(DesignerSession::kMostBytes + 1, ' '));
    EXPECT_NE(larger.find("bytes; at most"), std::string::npos) << larger;
    EXPECT_FALSE(_output.isPlaying);
}

TEST_F(DesignerSessions, OtherMistakesChangeNothing)
{
    play();
    for (const std::string& text :
         {command("update_parameters", {{"evaluator_params", 1}}),
          command("update_parameters", {{"evaluator_params", {{"time", 0}}}}),
          updateParameters({{"strength", "strong"}}),
          command("user_parameter", {{"name", 1}, {"value", 1}}),
          command("user_parameters", {{"user_parameters", json::array()}}),
          command("parameter_time", {{"time", nullptr}}),
          command("geo_transform_matrix", {{"transform", {{1, 2}, {3, 4}}}}),
          command("update_tracking", {{"enabled", "yes"}}),
          command("user_parameter", {{"name", std::string(70000, 'x')}, {"value", 1}})})
    {
        const std::string answer = take(text, 0.1);
        EXPECT_EQ(json::parse(answer)["cmd"], "error") << text.substr(0, 60);
        EXPECT_TRUE(_output.isPlaying) << text.substr(0, 60);
        EXPECT_EQ(_output.parameters, "strength=0.5");
    }
    const std::size_t told = _told.size();
    take(command("update_tracking", {{"enabled", "yes"}}), 0.1);
    take(command("update_tracking", {{"enabled", "yes"}}), 0.1);
    EXPECT_EQ(_told.size(), told + 1) << "the same in a row is told once";
}

TEST_F(DesignerSessions, TellsAnUnknownCommandOnceByItsName)
{
    play();
    EXPECT_EQ(take(command("update_weather", {{"rain", true}})), "");
    EXPECT_EQ(take(command("update_weather", {{"rain", false}})), "");
    EXPECT_EQ(take(command("dance\x1b[2J", json::object())), "");
    ASSERT_EQ(_told.size(), 2U);
    EXPECT_NE(_told[0].find("\"update_weather\""), std::string::npos) << _told[0];
    EXPECT_EQ(_told[1].find('\x1b'), std::string::npos);
    EXPECT_TRUE(_output.isPlaying);
}

TEST_F(DesignerSessions, NoNumberThatIsNotFiniteGoesOut)
{
    json broken = pattern();
    const json zero = {{"type", "constant"}, {"value", 0.0}};
    broken["pattern_transform"]["intensity_factor"] = {
        {"type", "formula"}, {"value", {{"type", "divide"}, {"value", {zero, zero}}}}};
    EXPECT_EQ(take(updatePattern(broken)), "");
    EXPECT_EQ(take(updatePlaystart(0.0)), "");
    const std::string text = _session.update(0.05);
    EXPECT_EQ(text.find("null"), std::string::npos);
    EXPECT_EQ(text.find("nan"), std::string::npos);
    ASSERT_EQ(_told.size(), 1U);
    EXPECT_NE(_told[0].find("NaN"), std::string::npos);
    json loud = pattern();
    loud["pattern_transform"]["intensity_factor"]["value"] = 4.0;
    EXPECT_EQ(take(updatePattern(loud), 0.1), "");
    EXPECT_DOUBLE_EQ(intensity(evals(0.15).back()), 1.0);
    ASSERT_EQ(_told.size(), 2U);
    EXPECT_NE(_told[1].find("limited"), std::string::npos);
}

TEST_F(DesignerSessions, ForgetsAClientThatHasGone)
{
    play();
    _session.reset();
    EXPECT_FALSE(_output.isPlaying);
    EXPECT_EQ(_session.update(0.1), "");
    EXPECT_NE(take(updatePlaystart(0.0), 0.2).find("there is no pattern"), std::string::npos);
}
