#pragma once

#include "haptics/sensation/SensationReader.h"

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

/// Patterns of tests, as files have them.
namespace patterns
{

using Json = nlohmann::ordered_json;

inline Json number(double value)
{
    return {{"type", "f64"}, {"value", value}};
}

inline Json parameter(const std::string& name)
{
    return {{"type", "param"}, {"value", name}};
}

inline Json variant(const std::string& name, const Json& params = Json::object())
{
    return {{"name", name}, {"params", params}};
}

inline Json coords(double x, double y, double z, const std::string& transition = "linear")
{
    return {{"coords", {{"x", x}, {"y", y}, {"z", z}}}, {"transition", variant(transition)}};
}

inline Json circle(const Json& radius,
                   const Json& draw_Hz,
                   const Json& modulation_Hz = number(0.0),
                   const std::string& transition = "linear")
{
    return {{"brush",
             variant("circle",
                     {{"radius", radius}, {"am_freq", modulation_Hz}, {"stm_freq", draw_Hz}})},
            {"transition", variant(transition)}};
}

inline Json intensity(const Json& value, const std::string& transition = "linear")
{
    return {{"intensity", variant("constant", {{"value", value}})},
            {"transition", variant(transition)}};
}

inline Json standard(double time_ms, const Json& place)
{
    return {{"type", "standard"}, {"time", time_ms}, {"coords", place}, {"cjumps", Json::array()}};
}

inline Json pause(double time_ms)
{
    return {{"type", "pause"}, {"time", time_ms}, {"cjumps", Json::array()}};
}

inline Json stop(double time_ms)
{
    return {{"type", "stop"}, {"time", time_ms}};
}

inline Json jump(const std::string& name, const std::string& comparison, double value, double to_ms)
{
    return {
        {"condition", {{"parameter", name}, {"operator", variant(comparison)}, {"value", value}}},
        {"jump_to", to_ms}};
}

/// A pattern with these keyframes that transforms nothing.
inline Json pattern(const std::vector<Json>& keyframes)
{
    const Json zero = {{"x", number(0.0)}, {"y", number(0.0)}, {"z", number(0.0)}};
    const Json one = {{"x", number(1.0)}, {"y", number(1.0)}, {"z", number(1.0)}};
    return {{"$DATA_FORMAT", "MidAirHapticsAnimationFileFormat"},
            {"$REVISION", "0.1.0-alpha.3"},
            {"name", "test"},
            {"keyframes", keyframes},
            {"pattern_transform",
             {{"geometric_transforms",
               {{"translate", zero}, {"rotation", number(0.0)}, {"scale", one}}},
              {"intensity_factor", number(1.0)},
              {"playback_speed", number(1.0)}}},
            {"user_parameter_definitions", Json::object()}};
}

inline void define(Json& pattern, const std::string& name, const Json& rest)
{
    pattern["user_parameter_definitions"][name] = rest;
    pattern["user_parameter_definitions"][name]["step"] = 1;
}

inline std::shared_ptr<const midair::haptics::Sensation> read(const Json& pattern)
{
    return std::make_shared<const midair::haptics::Sensation>(
        midair::haptics::readSensation(pattern.dump(1), "test.adaptics"));
}

} // namespace patterns
