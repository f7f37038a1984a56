#include "haptics/sensation/SensationClassics.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Quantity.h"
#include "haptics/base/text/Words.h"
#include "haptics/sensation/ClassicMaker.h"
#include "haptics/sensation/UniformDraw.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

/// Places in mm, as of fingertips.
using Places = std::vector<Eigen::Vector3d>;

/// A classic; figures are those of Ultraleap's and AdapTics' examples, where they have it.
struct Classic
{
    const char* name;
    const char* sentence;
    std::vector<ClassicParameter> parameters; ///< besides "intensity"
    void (*make)(ClassicMaker& maker, const Places& places);
    const char* placesName = nullptr; ///< null: it has no places
    Places places = {};               ///< their default
};

ClassicParameter frequencyOf(double standard_Hz)
{
    return {"frequency", "Hz", standard_Hz, 0.0, 500.0};
}

constexpr ClassicParameter kRepeat = {"repeat", "yes/no", 0.0, 0.0, 1.0};
constexpr double kMostClassic_mm = 200.0;
constexpr double kLeastClassic_ms = 10.0;
constexpr double kMostClassic_ms = 60000.0;

ClassicParameter sizeOf(const char* name, double standard_mm)
{
    return {name, "mm", standard_mm, 0.0, kMostClassic_mm};
}

ClassicParameter placeOf(const char* name, double standard_mm)
{
    return {name, "mm", standard_mm, -kMostClassic_mm, kMostClassic_mm};
}

ClassicParameter angleOf(const char* name, double standard_deg)
{
    return {name, "deg", standard_deg, -360.0, 360.0};
}

ClassicParameter durationOf(const char* name, double standard_ms)
{
    return {name, "ms", standard_ms, kLeastClassic_ms, kMostClassic_ms};
}

void makeCircle(ClassicMaker& maker, const Places&)
{
    maker.place(0.0, ClassicMaker::circle(maker["radius"], maker["frequency"]));
}

void makeLine(ClassicMaker& maker, const Places&)
{
    maker.place(0.0, ClassicMaker::line(maker["length"], maker["rotation"], maker["frequency"]));
}

void makeLissajous(ClassicMaker& maker, const Places&)
{
    const double degree = base::toRadians(1.0);
    SensationBrush brush;
    brush.kind = SensationBrush::Kind::LISSAJOUS;
    brush.x_mm = maker["x"];
    brush.y_mm = maker["y"];
    brush.a = maker["a"];
    brush.b = maker["b"];
    brush.phase_rad = maker["phase"] * degree;
    brush.rotation = maker["rotation"] * degree;
    brush.draw_Hz = maker["frequency"];
    maker.place(0.0, brush);
}

// The modulation is 0.5 (1 - cos 2 pi f t).
void makePoint(ClassicMaker& maker, const Places&)
{
    SensationBrush brush = ClassicMaker::circle(maker["radius"], maker["frequency"]);
    brush.modulation_Hz = maker["modulation"];
    maker.place(0.0, brush);
    maker.sensation.modulationStart = 0.5;
}

void makePalmScan(ClassicMaker& maker, const Places&)
{
    const SensationBrush bar = ClassicMaker::line(maker["width"], 0.0, maker["frequency"]);
    maker.place(0.0, bar, {0.0, -0.5, 0.0});
    maker.place(2000.0, bar, {0.0, 0.5, 0.0});
    maker.stop();
    maker.sensation.transform.scale[1] = maker["to"] - maker["from"];
    maker.sensation.transform.translation_mm[1] = (maker["to"] + maker["from"]) * 0.5;
    maker.sensation.speed = SensationNumber(2000.0) / maker["duration"];
}

void makePulse(ClassicMaker& maker, const Places&)
{
    maker.place(0.0, ClassicMaker::circle(maker["from"], maker["frequency"]));
    maker.pause(1000.0, ClassicMaker::circle(maker["to"], maker["frequency"]));
    maker.stop();
    maker.sensation.speed = SensationNumber(1000.0) / maker["duration"];
}

// A polygon of 72 corners is nowhere further than 0.1 % of its radius from the circle.
void makeDial(ClassicMaker& maker, const Places&)
{
    constexpr int kCorners = 72;
    SensationBrush brush = ClassicMaker::circle(maker["size"], maker["frequency"]);
    brush.modulation_Hz = maker["modulation"];
    for (int corner = 0; corner <= kCorners; ++corner)
    {
        const double share = static_cast<double>(corner) / kCorners;
        const double angle_rad = base::kTwoPi * share;
        maker.place(1000.0 * share, brush, {std::cos(angle_rad), std::sin(angle_rad), 0.0});
    }
    maker.loop();
    maker.sensation.transform.scale = {maker["radius"], maker["radius"], 1.0};
    maker.sensation.speed = maker["rate"];
    maker.sensation.modulationStart = 0.5;
}

// A line from the palm to a fingertip, to another one every 100 ms.
void makeLightning(ClassicMaker& maker, const Places& tips)
{
    constexpr int kStrokes = 40;
    std::size_t tip = 0;
    for (int stroke = 0; stroke <= kStrokes; ++stroke)
    {
        const double draw = uniformDraw(1, static_cast<std::uint64_t>(stroke));
        if (tips.size() > 1)
            tip =
                (tip + 1 + static_cast<std::size_t>(draw * static_cast<double>(tips.size() - 1))) %
                tips.size();
        const Eigen::Vector3d& to = tips[tip];
        SensationKeyframe& frame =
            maker.place(100.0 * stroke,
                        ClassicMaker::line(to.head<2>().norm(),
                                           base::toDegrees(std::atan2(to.y(), to.x())),
                                           maker["frequency"]),
                        0.5 * to);
        frame.positionTransition = frame.brushTransition = SensationTransition::STEP;
    }
    maker.loop();
}

// The envelope rises within a tenth of the time, and falls to its end.
void makeClick(ClassicMaker& maker, const Places&)
{
    const SensationBrush brush = ClassicMaker::circle(maker["radius"], maker["frequency"]);
    ClassicMaker::setIntensity(maker.place(0.0, brush), 0.0);
    maker.pause(10.0, brush);
    ClassicMaker::setIntensity(maker.pause(100.0, brush), 0.0);
    maker.stop();
    maker.sensation.speed = SensationNumber(100.0) / maker["duration"];
}

// Two thirds of the period on, one off.
void makeTapping(ClassicMaker& maker, const Places&)
{
    const SensationBrush brush = ClassicMaker::circle(maker["radius"], maker["frequency"]);
    maker.place(0.0, brush).intensityTransition = SensationTransition::STEP;
    ClassicMaker::setIntensity(maker.pause(200.0, brush), 0.0, SensationTransition::STEP);
    maker.pause(300.0, brush);
    maker.loop();
    maker.sensation.speed = SensationNumber(300.0) / maker["period"];
}

void makeHeartbeat(ClassicMaker& maker, const Places&)
{
    double time_ms = 0.0;
    for (const double radius_mm : {10.0, 15.0, 5.0, 25.0, 8.0, 10.0})
    {
        const SensationBrush brush =
            ClassicMaker::circle(maker["size"] * (radius_mm / 25.0), maker["frequency"]);
        if (time_ms == 0.0)
            maker.place(time_ms, brush);
        else
            maker.pause(time_ms, brush);
        time_ms += 200.0;
    }
    maker.loop();
    maker.sensation.speed = maker["rate"];
}

// Drops grow and fade within 150 ms, 300 to 800 ms one after the other at full speed.
void makeRain(ClassicMaker& maker, const Places& places)
{
    const SensationNumber width_mm = (SensationNumber(0.5) + maker["strength"] * 2.0) * 25.0;
    double time_ms = 0.0;
    for (std::size_t drop = 0; drop <= places.size(); ++drop)
    {
        maker
            .place(time_ms,
                   ClassicMaker::circle(2.0, maker["frequency"]),
                   places[drop % places.size()])
            .positionTransition = SensationTransition::STEP;
        if (drop == places.size()) break;
        SensationKeyframe& end =
            maker.pause(time_ms + 150.0, ClassicMaker::circle(width_mm, maker["frequency"]));
        end.brushTransition = SensationTransition::STEP;
        ClassicMaker::setIntensity(end, 0.0, SensationTransition::STEP);
        time_ms += 300.0 + 500.0 * uniformDraw(2, drop);
    }
    maker.loop();
    maker.sensation.speed = SensationNumber(0.5) + maker["amount"] * 2.0;
}

void makeForcefield(ClassicMaker& maker, const Places&)
{
    makeLine(maker, {});
    maker.sensation.transform.translation_mm = {maker["x"], maker["y"], maker["z"]};
}

/// Places spread evenly over a disc of 45 mm, each far from the one before.
Places placesOfRain()
{
    constexpr std::size_t kDrops = 12;
    const double golden_rad = base::kPi * (3.0 - std::sqrt(5.0));
    Places places;
    for (std::size_t drop = 0; drop < kDrops; ++drop)
    {
        const double share = static_cast<double>((5 * drop) % kDrops) + 0.5;
        const double radius_mm = 45.0 * std::sqrt(share / static_cast<double>(kDrops));
        places.emplace_back(radius_mm * std::cos(golden_rad * share),
                            radius_mm * std::sin(golden_rad * share),
                            0.0);
    }
    return places;
}

/// Fingertips of a flat right hand of average size (190 mm), from thumb to little finger, seen from
/// the palm's middle: x to the thumb's side is negative, y towards the fingers.
Places placesOfTips()
{
    return {{-70.0, 40.0, 0.0},
            {-28.0, 95.0, 0.0},
            {0.0, 105.0, 0.0},
            {22.0, 97.0, 0.0},
            {45.0, 75.0, 0.0}};
}

// A table.
// NOLINTNEXTLINE(readability-function-size)
const std::vector<Classic>& allClassics()
{
    static const std::vector<Classic> all = {
        {"circle", "a circle", {sizeOf("radius", 20.0), frequencyOf(70.0)}, makeCircle},
        {"line",
         "a line, drawn to and fro",
         {sizeOf("length", 80.0), angleOf("rotation", 0.0), frequencyOf(125.0)},
         makeLine},
        {"lissajous",
         "a Lissajous curve",
         {sizeOf("x", 10.0),
          sizeOf("y", 10.0),
          {"a", "", 3.0, -100.0, 100.0},
          {"b", "", 2.0, -100.0, 100.0},
          angleOf("phase", 90.0),
          angleOf("rotation", 0.0),
          frequencyOf(40.0)},
         makeLissajous},
        {"point-am",
         "a small circle with amplitude modulation",
         {sizeOf("radius", 5.0), frequencyOf(70.0), {"modulation", "Hz", 143.0, 0.0, 500.0}},
         makePoint},
        {"palm-scan",
         "a bar that goes along the hand, once",
         {sizeOf("width", 100.0),
          placeOf("from", -80.0),
          placeOf("to", 100.0),
          durationOf("duration", 2000.0),
          frequencyOf(70.0),
          kRepeat},
         makePalmScan},
        {"pulse",
         "a circle that grows, once",
         {sizeOf("from", 10.0),
          sizeOf("to", 50.0),
          durationOf("duration", 1000.0),
          frequencyOf(70.0),
          kRepeat},
         makePulse},
        {"dial",
         "a small circle with amplitude modulation that goes round a larger one",
         {sizeOf("radius", 25.0),
          sizeOf("size", 5.0),
          {"rate", "Hz", 1.0, 0.0, 20.0},
          frequencyOf(70.0),
          {"modulation", "Hz", 143.0, 0.0, 500.0}},
         makeDial},
        {"lightning",
         "a line from the palm to a fingertip, another one every 100 ms",
         {frequencyOf(70.0)},
         makeLightning,
         "tips",
         placesOfTips()},
        {"click",
         "a circle that comes at once and fades",
         {sizeOf("radius", 20.0), durationOf("duration", 100.0), frequencyOf(80.0), kRepeat},
         makeClick},
        {"tapping",
         "a circle that comes and goes",
         {sizeOf("radius", 10.0), durationOf("period", 300.0), frequencyOf(70.0)},
         makeTapping},
        {"heartbeat",
         "a circle that beats",
         {sizeOf("size", 25.0), {"rate", "Hz", 1.0, 0.0, 3.0}, frequencyOf(100.0)},
         makeHeartbeat},
        {"rain",
         "drops that grow and fade",
         {{"strength", "", 0.25, 0.0, 1.0}, {"amount", "", 0.25, 0.0, 1.0}, frequencyOf(100.0)},
         makeRain,
         "places",
         placesOfRain()},
        {"forcefield",
         "a line where a plane cuts the hand; the program moves it",
         {sizeOf("length", 80.0),
          angleOf("rotation", 0.0),
          placeOf("x", 0.0),
          placeOf("y", 0.0),
          placeOf("z", 0.0),
          frequencyOf(100.0)},
         makeForcefield}};
    return all;
}

std::vector<ClassicParameter> parametersOf(const Classic& classic)
{
    std::vector<ClassicParameter> all = classic.parameters;
    all.push_back({"intensity", "", 1.0, 0.0, 1.0});
    return all;
}

std::string unitText(const ClassicParameter& one)
{
    return *one.unit == '\0' ? "" : fmt::format(" {}", one.unit);
}

/// Reads a parameter's value. Throws InputError, which begins with \a what.
double readValue(const ClassicParameter& one, const std::string& text, const std::string& what)
{
    double value = 0.0;
    bool isYes = false;
    const bool isFlag = std::string(one.unit) == "yes/no";
    if (isFlag && base::parseYesNo(text, isYes)) return isYes ? 1.0 : 0.0;
    if (isFlag)
        throw base::InputError(
            fmt::format("{} is \"{}\"; it must be yes or no", what, base::printable(text, 60)));
    if (!base::parseQuantity(text, one.unit, value) || value < one.low || value > one.high)
        throw base::InputError(fmt::format("{} is \"{}\"; it must be within {} .. {}{}",
                                           what,
                                           base::printable(text, 60),
                                           base::shortNumber(one.low),
                                           base::shortNumber(one.high),
                                           unitText(one)));
    return value;
}

Places readPlaces(const std::string& text, const std::string& what)
{
    std::vector<std::array<double, 3>> read;
    if (!base::parsePlaces(text, read) || read.empty())
        throw base::InputError(fmt::format("{} is \"{}\"; it must be {}, such as 0 95 0 mm",
                                           what,
                                           base::printable(text, 60),
                                           base::kPlacesExpected));
    Places places;
    for (const std::array<double, 3>& one : read)
    {
        places.push_back(1e3 * Eigen::Vector3d(one[0], one[1], one[2]));
        if (!(places.back().norm() <= 1e3))
            throw base::InputError(fmt::format("{} has a place further than 1 m away", what));
    }
    return places;
}

/// Splits "name=value&name=value".
std::map<std::string, std::string> queryOf(const std::string& text, const std::string& what)
{
    std::map<std::string, std::string> query;
    if (text.empty()) return query;
    for (const std::string& part : base::splitAt(text, '&'))
    {
        const std::size_t equal = part.find('=');
        if (equal == std::string::npos || equal == 0)
            throw base::InputError(
                fmt::format("{}: \"{}\" should be name=value", what, base::printable(part, 60)));
        if (!query.emplace(part.substr(0, equal), part.substr(equal + 1)).second)
            throw base::InputError(fmt::format(
                "{}: {} is there twice", what, base::printable(part.substr(0, equal), 60)));
    }
    return query;
}

const Classic& classicOf(const std::string& name)
{
    for (const Classic& one : allClassics())
        if (name == one.name) return one;
    const std::vector<std::string> known = sensationClassics();
    throw base::InputError(fmt::format("there is no sensation \"{}\"{}; known are {}",
                                       base::printable(name, 60),
                                       base::didYouMean(name, known),
                                       fmt::join(known, ", ")));
}

} // namespace

std::vector<std::string> sensationClassics()
{
    std::vector<std::string> names;
    for (const Classic& one : allClassics())
        names.emplace_back(one.name);
    return names;
}

bool isClassicSensation(const std::string& text)
{
    const std::vector<std::string> known = sensationClassics();
    return std::find(known.begin(), known.end(), text.substr(0, text.find('?'))) != known.end();
}

std::string describeClassic(const std::string& name)
{
    for (const Classic& one : allClassics())
    {
        if (name != one.name) continue;
        std::string text = fmt::format("{}: {}\n", one.name, one.sentence);
        for (const ClassicParameter& parameter : parametersOf(one))
            text += fmt::format("  {}={} ({} .. {}{})\n",
                                parameter.name,
                                base::shortNumber(parameter.standard),
                                base::shortNumber(parameter.low),
                                base::shortNumber(parameter.high),
                                unitText(parameter));
        if (one.placesName != nullptr)
            text += fmt::format("  {}={}\n", one.placesName, base::kPlacesExpected);
        return text;
    }
    return {};
}

Sensation classicSensation(const std::string& text)
{
    const std::size_t mark = text.find('?');
    const Classic& classic = classicOf(text.substr(0, mark));
    const std::vector<ClassicParameter> parameters = parametersOf(classic);
    std::vector<std::string> known;
    known.reserve(parameters.size() + 1);
    for (const ClassicParameter& one : parameters)
        known.emplace_back(one.name);
    if (classic.placesName != nullptr) known.emplace_back(classic.placesName);

    ClassicMaker maker(classic.name, parameters);
    Places places = classic.places;
    const std::string rest = mark == std::string::npos ? "" : text.substr(mark + 1);
    for (const auto& [name, value] : queryOf(rest, classic.name))
    {
        const std::string what = fmt::format("{} of {}", base::printable(name, 60), classic.name);
        const std::string& wanted = name;
        const auto found =
            std::find_if(parameters.begin(),
                         parameters.end(),
                         [&wanted](const ClassicParameter& one) { return wanted == one.name; });
        if (found != parameters.end())
            maker.setStandard(name, readValue(*found, value, what));
        else if (classic.placesName != nullptr && name == classic.placesName)
            places = readPlaces(value, what);
        else
            throw base::InputError(fmt::format("{} has no parameter \"{}\"{}; it has {}",
                                               classic.name,
                                               base::printable(name, 60),
                                               base::didYouMean(name, known),
                                               fmt::join(known, ", ")));
    }
    classic.make(maker, places);
    return maker.sensation;
}

} // namespace midair::haptics
