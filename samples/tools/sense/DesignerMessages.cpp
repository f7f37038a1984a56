#include "samples/tools/sense/DesignerMessages.h"

#include <Eigen/LU>

#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

using Json = base::JsonValue::Json;

constexpr double kMostParameter = 1e12;
constexpr double kMostEntry = 1e6;   // of a matrix, mm
constexpr double kUnevenness = 1e-4; // of a rotation

double finiteOrZero(double value)
{
    return std::isfinite(value) ? value : 0.0;
}

std::string messageOf(const char* command, Json data)
{
    Json message;
    message["cmd"] = command;
    message["data"] = std::move(data);
    return message.dump(-1, ' ', false, Json::error_handler_t::replace);
}

// Joints of SenseHand.
constexpr int kPalm = 0, kThumb = 2, kIndex = 6, kLittle = 21, kOfFinger = 5;

Json vectorOf(const Eigen::Vector3d& vector)
{
    return {{"x", finiteOrZero(vector.x())},
            {"y", finiteOrZero(vector.y())},
            {"z", finiteOrZero(vector.z())}};
}

Json boneOf(const SenseHand& hand, int start, int end)
{
    return {{"start", vectorOf(1e3 * hand.joints.col(start))},
            {"end", vectorOf(1e3 * hand.joints.col(end))},
            {"width", finiteOrZero(1e3 * (hand.radii_m[start] + hand.radii_m[end]))}};
}

Json digitsOf(const SenseHand& hand)
{
    Json digits = Json::array();
    Json thumb = Json::array({boneOf(hand, kThumb, kThumb)});
    for (int bone = 0; bone < 3; ++bone)
        thumb.push_back(boneOf(hand, kThumb + bone, kThumb + bone + 1));
    digits.push_back({{"bones", std::move(thumb)}});
    for (int first = kIndex; first < SenseHand::kJoints; first += kOfFinger)
    {
        Json bones = Json::array();
        for (int bone = first; bone < first + kOfFinger - 1; ++bone)
            bones.push_back(boneOf(hand, bone, bone + 1));
        digits.push_back({{"bones", std::move(bones)}});
    }
    return digits;
}

// Over the knuckles.
double palmWidth_m(const SenseHand& hand)
{
    constexpr int kIndexKnuckle = kIndex + 1, kLittleKnuckle = kLittle + 1;
    return (hand.joints.col(kIndexKnuckle) - hand.joints.col(kLittleKnuckle)).norm() +
           hand.radii_m[kIndexKnuckle] + hand.radii_m[kLittleKnuckle];
}

} // namespace

DesignerParameters parametersIn(const base::JsonValue& value)
{
    if (!value.json().is_object()) value.wrong("an object of numbers");
    if (value.json().size() > kMostDesignerParameters)
        value.fail(fmt::format("has {} entries; at most {} are possible",
                               value.json().size(),
                               kMostDesignerParameters));
    DesignerParameters all;
    for (const auto& [name, unused] : value.json().items())
        all[name] = value.required(name, "a number")
                        .number(-kMostParameter, kMostParameter, "a number within -1e12 .. 1e12");
    return all;
}

Eigen::Matrix4d transformIn(const base::JsonValue& value)
{
    const std::string right = "4 rows of 4 numbers: a rotation and a translation (mm)";
    if (value.list(right, 4).size() != 4) value.wrong(right);
    Eigen::Matrix4d matrix;
    for (int row = 0; row < 4; ++row)
    {
        const base::JsonValue entries = value[static_cast<std::size_t>(row)];
        if (entries.list(right, 4).size() != 4) entries.wrong(right);
        for (int column = 0; column < 4; ++column)
            matrix(row, column) =
                entries[static_cast<std::size_t>(column)].number(-kMostEntry, kMostEntry, right);
    }
    const Eigen::Matrix3d turn = matrix.topLeftCorner<3, 3>();
    const bool isRigid = (turn * turn.transpose()).isIdentity(kUnevenness) &&
                         turn.determinant() > 0.0 &&
                         matrix.row(3).isApprox(Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0));
    if (!isRigid) value.fail("has a scale, a mirror or a perspective; it must be " + right);
    matrix.topRightCorner<3, 1>() *= 1e-3;
    return matrix;
}

std::string patternFrom(const std::string& json, double begin_ms)
{
    if (begin_ms == 0.0) return json;
    Json pattern = Json::parse(json);
    for (Json& frame : pattern["keyframes"])
    {
        frame["time"] = frame["time"].get<double>() - begin_ms;
        if (!frame.contains("cjumps") || !frame["cjumps"].is_array())
            continue; // a stop's are not read
        for (Json& jump : frame["cjumps"])
            if (jump.is_object() && jump.contains("jump_to") && jump["jump_to"].is_number())
                jump["jump_to"] = jump["jump_to"].get<double>() - begin_ms;
    }
    return pattern.dump(-1, ' ', false, Json::error_handler_t::replace);
}

haptics::Sensation patternFrom(haptics::Sensation sensation, double begin_ms)
{
    for (haptics::SensationKeyframe& frame : sensation.keyframes)
    {
        frame.time_ms -= begin_ms;
        for (haptics::SensationJump& jump : frame.jumps)
            jump.to_ms -= begin_ms;
    }
    return sensation;
}

std::string playbackUpdate(const std::vector<DesignerSample>& samples)
{
    Json evals = Json::array();
    for (const DesignerSample& one : samples)
    {
        Json eval;
        Json& point = eval["ul_control_point"];
        point["coords"]["x"] = finiteOrZero(one.position_mm.x());
        point["coords"]["y"] = finiteOrZero(one.position_mm.y());
        point["coords"]["z"] = finiteOrZero(one.position_mm.z());
        point["intensity"] = finiteOrZero(one.intensity);
        eval["pattern_time"] = finiteOrZero(one.pattern_ms);
        eval["stop"] = one.isStopped;
        eval["next_eval_params"]["last_eval_pattern_time"] = finiteOrZero(one.pattern_ms);
        eval["next_eval_params"]["time_offset"] = finiteOrZero(one.offset_ms);
        evals.push_back(std::move(eval));
    }
    return messageOf("playback_update", Json{{"evals", std::move(evals)}});
}

std::string trackingData(const std::optional<SenseHand>& hand)
{
    Json frame;
    frame["hand"] = nullptr;
    if (hand)
        frame["hand"] = {{"chirality", hand->isLeft ? "Left" : "Right"},
                         {"palm",
                          {{"position", vectorOf(1e3 * hand->joints.col(kPalm))},
                           {"direction", vectorOf(-hand->turn.col(2))},
                           {"normal", vectorOf(-hand->turn.col(1))},
                           {"width", finiteOrZero(1e3 * palmWidth_m(*hand))}}},
                         {"digits", digitsOf(*hand)}};
    return messageOf("tracking_data", Json{{"tracking_frame", std::move(frame)}});
}

std::string errorMessage(const std::string& what)
{
    return messageOf("error", Json{{"message", what}});
}

} // namespace midair::samples
