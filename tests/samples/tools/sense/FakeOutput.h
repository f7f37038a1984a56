#pragma once

#include "haptics/base/InputError.h"
#include "samples/tools/sense/SenseOutput.h"

#include <string>
#include <vector>

#include <fmt/format.h>
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
    void update(double) override {}

    std::string refusal; ///< of the next pattern
    std::string sensation;
    std::string parameters;
    Eigen::Matrix4d transform = Eigen::Matrix4d::Identity();
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
