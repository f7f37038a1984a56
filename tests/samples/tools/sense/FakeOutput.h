#pragma once

#include "haptics/base/InputError.h"
#include "samples/tools/sense/SenseOutput.h"

#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

/// Keeps what it is asked for, in place of an array.
struct FakeOutput : midair::samples::SenseOutput
{
    void setSensation(const std::string& text) override
    {
        if (!refusal.empty()) throw midair::base::InputError(refusal);
        sensation = text;
        calls.emplace_back("sensation");
    }
    void setParameters(const midair::samples::SenseParameters& all) override
    {
        std::string text;
        for (const auto& [name, value] : all)
            text += fmt::format("{}{}={}", text.empty() ? "" : "; ", name, value);
        parameters = text;
    }
    void setTransform(const Eigen::Matrix4d& matrix) override { transform = matrix; }
    void setTracking(bool isOn) override { isTracking = isOn; }
    void begin() override
    {
        isPlaying = true;
        calls.emplace_back("begin");
    }
    void end() override
    {
        isPlaying = false;
        calls.emplace_back("end");
    }
    std::optional<midair::samples::SenseHand> hand() const override { return shownHand; }
    void update(double) override {}

    std::string refusal; ///< of the next pattern
    std::string sensation;
    std::string parameters;
    Eigen::Matrix4d transform = Eigen::Matrix4d::Identity();
    std::optional<midair::samples::SenseHand> shownHand;
    bool isTracking = false;
    bool isPlaying = false;
    std::vector<std::string> calls;
};

/// A command of the Designer.
inline std::string command(const std::string& name, const nlohmann::json& data)
{
    return nlohmann::json{{"cmd", name}, {"data", data}}.dump();
}

/// Returns a pattern along x, 1 mm a ms, which stops at \a stop_ms; its intensity is the parameter
/// strength, 0.5 until it is set, and its height 200 mm.
inline nlohmann::json pattern(double stop_ms = 1000.0, double y_mm = 0.0)
{
    using nlohmann::json;
    const auto number = [](double value) { return json{{"type", "f64"}, {"value", value}}; };
    const auto named = [](const char* name) {
        return json{{"name", name}, {"params", json::object()}};
    };
    const auto place = [&](double time_ms)
    {
        const json xyz = {{"x", time_ms}, {"y", y_mm}, {"z", 0.0}};
        const json value = {{"name", "constant"},
                            {"params", {{"value", {{"type", "param"}, {"value", "strength"}}}}}};
        return json{{"type", "standard"},
                    {"time", time_ms},
                    {"coords", {{"coords", xyz}, {"transition", named("linear")}}},
                    {"intensity", {{"intensity", value}, {"transition", named("linear")}}},
                    {"cjumps", json::array()}};
    };
    const auto three = [&](double x, double y, double z) {
        return json{{"x", number(x)}, {"y", number(y)}, {"z", number(z)}};
    };
    return {
        {"$DATA_FORMAT", "MidAirHapticsAnimationFileFormat"},
        {"$REVISION", "0.1.0-alpha.3"},
        {"name", "line"},
        {"keyframes", {place(0.0), place(stop_ms), {{"type", "stop"}, {"time", stop_ms}}}},
        {"pattern_transform",
         {{"geometric_transforms",
           {{"translate", three(0, 0, 200)}, {"rotation", number(0)}, {"scale", three(1, 1, 1)}}},
          {"intensity_factor", number(1)},
          {"playback_speed", number(1)}}},
        {"user_parameter_definitions",
         {{"strength", {{"default", 0.5}, {"step", 0.1}, {"min", 0.0}, {"max", 1.0}}}}}};
}

inline std::string updatePattern(const nlohmann::json& what)
{
    return command("update_pattern", {{"pattern_json", what.dump()}});
}

/// As the Designer starts at \a time_ms of the pattern.
inline std::string updatePlaystart(double time_ms)
{
    return command("update_playstart",
                   {{"playstart", 1.7e12 - time_ms}, {"playstart_offset", -time_ms}});
}

inline std::string stopMessage()
{
    return command("update_playstart", {{"playstart", 0}, {"playstart_offset", -1.7e12}});
}

inline std::string updateParameters(const nlohmann::json& user, double time_ms = 0.0)
{
    const nlohmann::json identity = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    return command(
        "update_parameters",
        {{"evaluator_params",
          {{"time", time_ms}, {"user_parameters", user}, {"geometric_transform", identity}}}});
}

/// A flat right hand over an array that looks up, its palm at \a height_m; its fingers point along
/// y, 20 mm apart, and all joints are 8 mm thick.
inline midair::samples::SenseHand handAbove(double height_m)
{
    midair::samples::SenseHand hand;
    hand.radii_m.setConstant(0.008);
    hand.turn.col(0) = Eigen::Vector3d::UnitX();
    hand.turn.col(1) = Eigen::Vector3d::UnitZ();
    hand.turn.col(2) = -Eigen::Vector3d::UnitY();
    hand.joints.row(2).setConstant(height_m);
    int joint = 2;
    for (int digit = 0; digit < 5; ++digit)
        for (int along = digit == 0 ? 1 : 0; along < 5; ++along, ++joint)
        {
            hand.joints(0, joint) = 0.02 * (digit - 2);
            hand.joints(1, joint) = 0.03 * along - 0.02;
        }
    return hand;
}

inline std::vector<double> numbersOf(const nlohmann::json& xyz)
{
    EXPECT_EQ(xyz.size(), 3U);
    return {xyz.at("x").get<double>(), xyz.at("y").get<double>(), xyz.at("z").get<double>()};
}

/// Reads tracking_data as AdapTics publishes its format (AdapticsWSServerMessage.json): fails for
/// what a reader of that would refuse. Returns the tracking frame.
inline nlohmann::json trackingFrameIn(const std::string& text)
{
    const nlohmann::json message = nlohmann::json::parse(text);
    EXPECT_EQ(message.at("cmd"), "tracking_data");
    const nlohmann::json frame = message.at("data").at("tracking_frame");
    if (!frame.contains("hand") || frame.at("hand").is_null()) return frame;
    const nlohmann::json& hand = frame.at("hand");
    EXPECT_TRUE(hand.at("chirality") == "Left" || hand.at("chirality") == "Right");
    for (const char* vector : {"position", "direction", "normal"})
        numbersOf(hand.at("palm").at(vector));
    EXPECT_TRUE(hand.at("palm").at("width").is_number());
    EXPECT_EQ(hand.at("digits").size(), 5U);
    for (const nlohmann::json& digit : hand.at("digits"))
    {
        EXPECT_EQ(digit.at("bones").size(), 4U);
        for (const nlohmann::json& bone : digit.at("bones"))
        {
            numbersOf(bone.at("start"));
            numbersOf(bone.at("end"));
            EXPECT_TRUE(bone.at("width").is_number());
        }
    }
    return frame;
}
