#include "haptics/array/Reflector.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/JsonValue.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

using base::JsonValue;

constexpr double kFarthestReflector_m = 10.0; // catches lengths in millimetres
constexpr double kLongestSide_m = 100.0;
constexpr double kShortestSide_m = 1e-3;
constexpr double kMostPhase_rad = 1000.0;
constexpr double kMostAccuracy_mm = 1000.0;
constexpr double kLeastAccuracy_mm = 1e-6;
// A transducer beside another board, at the edge between both, must not seem to stand on it.
constexpr double kMostBoardAccuracy_mm = 3.0;

// Returns a direction across  normal, for planes without end.
Eigen::Vector3d anyAcross(const Eigen::Vector3d& normal)
{
    Eigen::Index least = 0;
    normal.cwiseAbs().minCoeff(&least);
    return normal.cross(Eigen::Vector3d::Unit(least)).normalized();
}

void readSides(const JsonValue& item, Reflector& one)
{
    const auto size = item.find("size_m");
    if (size)
    {
        const char* const right =
            "[length along 'along', length across it] in metres, each within 0.001 .. 100";
        one.size_m = size->vector(2, kLongestSide_m, right);
        if (!(one.size_m.array() >= kShortestSide_m).all()) size->wrong(right);
    }
    const auto along = item.find("along");
    if (!along && size)
        item.fail("lacks 'along'; it must be the direction of the first length of 'size_m'");
    one.along = along ? along->direction() : anyAcross(one.normal);
    if (!along) return;
    const double lean = one.along.dot(one.normal);
    if (std::abs(lean) > 1e-3) along->wrong("a direction across the normal");
    if (std::abs(lean) > 1e-14) one.along = (one.along - lean * one.normal).normalized();
}

Reflector readReflector(const JsonValue& item)
{
    item.object({"name",
                 "position_m",
                 "normal",
                 "along",
                 "size_m",
                 "reflection",
                 "reflectionPhase_rad",
                 "accuracy_mm",
                 "isBoard",
                 "comment"});
    Reflector one;
    if (const auto name = item.find("name")) one.name = name->string();
    one.position = item.required("position_m", "its centre [x, y, z] in metres")
                       .vector(3,
                               kFarthestReflector_m,
                               "its centre [x, y, z] in metres, each within -10 .. 10");
    one.normal = item.required("normal", "the direction [x, y, z] across it").direction();
    readSides(item, one);
    if (const auto found = item.find("reflection"))
        one.reflection = found->number(
            0.0, 1.0, "the amplitude of the reflected wave over that of the incident, 0 .. 1");
    if (const auto found = item.find("reflectionPhase_rad"))
        one.reflectionPhase_rad = found->number(
            -kMostPhase_rad, kMostPhase_rad, "an angle in radians, within -1000 .. 1000");
    if (const auto board = item.find("isBoard"))
    {
        if (!board->json().is_boolean()) board->wrong("true or false");
        one.isBoard = board->json().get<bool>();
    }
    one.accuracy_mm =
        one.isBoard
            ? item.number("accuracy_mm",
                          kLeastAccuracy_mm,
                          kMostBoardAccuracy_mm,
                          "the rms error of a board's plane along its normal in mm, within 1e-6 "
                          ".. 3")
            : item.number("accuracy_mm",
                          kLeastAccuracy_mm,
                          kMostAccuracy_mm,
                          "the rms error of its place along its normal in mm, within 1e-6 .. 1000");
    return one;
}

std::size_t boardsIn(const std::vector<Reflector>& reflectors)
{
    return static_cast<std::size_t>(std::count_if(
        reflectors.begin(), reflectors.end(), [](const Reflector& one) { return one.isBoard; }));
}

} // namespace

Eigen::Vector3d Reflector::across() const
{
    return normal.cross(along);
}

double Reflector::distanceTo(const Eigen::Vector3d& place) const
{
    const Eigen::Vector3d d = place - position;
    const Eigen::Vector2d beyond =
        (Eigen::Vector2d(along.dot(d), across().dot(d)).cwiseAbs() - 0.5 * size_m).cwiseMax(0.0);
    return std::hypot(heightOf(place), beyond.norm());
}

std::string Reflector::called(std::size_t index) const
{
    return name.empty() ? fmt::format("reflector {}", index) : "reflector '" + name + "'";
}

bool Reflector::operator==(const Reflector& other) const
{
    return name == other.name && position == other.position && normal == other.normal &&
           along == other.along && size_m == other.size_m && reflection == other.reflection &&
           reflectionPhase_rad == other.reflectionPhase_rad && accuracy_mm == other.accuracy_mm &&
           isBoard == other.isBoard;
}

bool isRoomIn(const std::vector<Reflector>& reflectors)
{
    return boardsIn(reflectors) + kMostReflectors > reflectors.size();
}

bool areValid(const std::vector<Reflector>& reflectors, std::string* error)
{
    std::string text;
    const std::size_t boards = boardsIn(reflectors), others = reflectors.size() - boards;
    if (others > kMostReflectors)
        text = fmt::format("reflectors are {}; at most {} are possible", others, kMostReflectors);
    else if (boards > kMostReflectingBoards)
        text = fmt::format("boards that reflect are in {} planes; at most {} are possible",
                           boards,
                           kMostReflectingBoards);
    for (std::size_t k = 0; k < reflectors.size() && text.empty(); ++k)
    {
        const Reflector& one = reflectors[k];
        const auto isUnit = [](const Eigen::Vector3d& v)
        { return std::abs(v.norm() - 1.0) < 1e-6; };
        if (!one.position.allFinite())
            text = "position is not finite";
        else if (!isUnit(one.normal) || !isUnit(one.along) ||
                 !(std::abs(one.normal.dot(one.along)) < 1e-6))
            text = "normal and along are not of unit length and perpendicular";
        else if (!(one.size_m.array() >= kShortestSide_m).all() ||
                 std::isinf(one.size_m[0]) != std::isinf(one.size_m[1]))
            text = fmt::format("size is {:g} x {:g} m; both sides must be at least {:g} m, or both "
                               "without end",
                               one.size_m[0],
                               one.size_m[1],
                               kShortestSide_m);
        else if (!(one.reflection >= 0.0 && one.reflection <= 1.0))
            text = fmt::format("reflection is {:g}; it must be within 0 .. 1", one.reflection);
        else if (!(std::abs(one.reflectionPhase_rad) <= kMostPhase_rad))
            text = fmt::format("reflectionPhase is {:g} rad; it must be within -1000 .. 1000",
                               one.reflectionPhase_rad);
        else if (const double most_mm = one.isBoard ? kMostBoardAccuracy_mm : kMostAccuracy_mm;
                 !(one.accuracy_mm >= kLeastAccuracy_mm && one.accuracy_mm <= most_mm))
            text = fmt::format(
                "accuracy is {:g} mm; it must be within 1e-6 .. {:g}", one.accuracy_mm, most_mm);
        if (!text.empty()) text = fmt::format("{}: its {}", one.called(k), text);
    }
    if (error != nullptr) *error = text;
    return text.empty();
}

std::vector<Reflector> readReflectors(const JsonValue& list)
{
    list.list("a list of reflectors", kMostReflectors + kMostReflectingBoards);
    std::vector<Reflector> reflectors;
    for (std::size_t k = 0; k < list.size(); ++k)
        reflectors.push_back(readReflector(list[k]));
    std::string why;
    if (!areValid(reflectors, &why)) list.fail("can't be used: " + why);
    return reflectors;
}

std::vector<Reflector> reflectorsFromJson(const std::string& json, const std::string& source)
{
    const JsonValue::Json text = base::parseJson(json, source);
    const JsonValue root(source, text);
    root.object({"reflectors", "comment"});
    return readReflectors(root.required("reflectors", "a list of reflectors"));
}

std::string reflectorsToJson(const std::vector<Reflector>& reflectors)
{
    JsonValue::Json list = JsonValue::Json::array();
    for (const Reflector& one : reflectors)
    {
        JsonValue::Json item;
        const auto listed = [](const Eigen::Vector3d& v) {
            return JsonValue::Json::array({v[0], v[1], v[2]});
        };
        if (!one.name.empty()) item["name"] = one.name;
        item["position_m"] = listed(one.position);
        item["normal"] = listed(one.normal);
        item["along"] = listed(one.along);
        if (one.size_m.allFinite())
            item["size_m"] = JsonValue::Json::array({one.size_m[0], one.size_m[1]});
        item["reflection"] = one.reflection;
        item["reflectionPhase_rad"] = one.reflectionPhase_rad;
        item["accuracy_mm"] = one.accuracy_mm;
        if (one.isBoard) item["isBoard"] = true;
        list.push_back(item);
    }
    return list.dump(-1, ' ', false, JsonValue::Json::error_handler_t::replace);
}

} // namespace midair::haptics
