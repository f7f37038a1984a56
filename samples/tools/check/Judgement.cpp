// What of the numbers of a check is a fault.
#include "samples/shared/SettingOptions.h"
#include "samples/tools/check/SceneCheck.h"

#include <algorithm>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

using osgMidair::HapticMessage;

/// Share of the pressure asked for, in Pa, below which an object counts as too weak.
constexpr double kWeakShare = 0.9;
/// A relative pressure above it was perhaps meant in Pa.
constexpr double kLargeRelative = 20.0;

bool isBad(const CheckedMessage& one)
{
    return one.message.severity != HapticMessage::NOTICE;
}

std::string points(unsigned int count, const char* why)
{
    return fmt::format("{} point{} left out: {}", count, count == 1 ? " is" : "s are", why);
}

/// Returns what was told of an object, without its path: messages with one of \a codes, or if there
/// are no codes, warnings and faults.
std::vector<std::string> toldOf(const CheckedObject& object,
                                const CheckedScene& scene,
                                const std::vector<std::string>& codes)
{
    const std::string path = object.path + ": ";
    std::vector<std::string> texts;
    for (const CheckedMessage& one : scene.messages)
    {
        const std::string& text = one.message.text;
        const bool isMeant =
            codes.empty() ? isBad(one)
                          : std::find(codes.begin(), codes.end(), one.message.code) != codes.end();
        if (isMeant && one.message.path == object.path && text.rfind(path, 0) == 0)
            texts.push_back(text.substr(path.size()));
    }
    return texts;
}

void append(std::vector<std::string>& all, const std::vector<std::string>& more)
{
    all.insert(all.end(), more.begin(), more.end());
}

bool isFeltByContact(const CheckedObject& object, const CheckedScene& scene)
{
    using Settings = osgMidair::HapticSettings;
    using Property = osgMidair::HapticProperty;
    const auto own = object.property.render;
    return own == Property::INHERIT ? scene.granted.render == Settings::CONTACT
                                    : own == Property::CONTACT;
}

/// Says why an object that is felt where hands touch it is felt in no frame.
void judgeUntouched(CheckedObject& object, const CheckedScene& scene)
{
    if (isRecording(scene.granted.hands))
        object.faults.push_back("it isn't felt: no hand of the recording touches it");
    else
        object.notes.push_back("it is felt where a hand touches it, which can't be tried: of hands "
                               "only recordings are read");
}

/// Says why an object is felt in no frame, in the words of the messages where there are some.
void judgeUnfelt(CheckedObject& object, const CheckedScene& scene)
{
    const osgMidair::HapticField::Object& out = object.leftOut;
    const std::vector<std::string> hidden = toldOf(object, scene, {"object.hidden"});
    const std::vector<std::string> told = toldOf(object, scene, {});
    const std::vector<std::string> tie = toldOf(object, scene, {"object.side"});
    if (out.outOfReach > 0 && !out.isUnreachable)
        object.notes.push_back("it is felt where a hand is near");
    else if (!object.hasShape && !hidden.empty())
        append(object.notes, hidden);
    else if (!told.empty())
        append(object.faults, told);
    else if (!tie.empty())
        append(object.faults, tie);
    else if (object.hasShape && !out.isUnreachable && isFeltByContact(object, scene))
        judgeUntouched(object, scene);
    else
        object.faults.push_back(!object.hasShape ? "it isn't felt: the messages say why"
                                : out.isUnreachable
                                    ? "it isn't felt: it is out of the array's reach"
                                    : "it isn't felt: none of its points is");
}

void judgePressure(CheckedObject& object, const CheckedScene& scene)
{
    const double cap_Pa = scene.statistics.maxPressure_Pa;
    const double ears_dB = scene.statistics.exposure.limit_dB;
    const std::string cap =
        cap_Pa > 0.0 && ears_dB > 0.0
            ? fmt::format("the cap of {:.4g} Pa or {:.4g} dB at ears", cap_Pa, ears_dB)
        : ears_dB > 0.0 ? fmt::format("the ear limit of {:.4g} dB", ears_dB)
                        : fmt::format("the cap of {:.4g} Pa", cap_Pa);
    const bool isPascal = object.property.pressureUnit == osgMidair::HapticProperty::PASCAL;
    if (scene.statistics.stop == "silenced")
        object.faults.push_back("the array is silent: the messages say why");
    else if (isPascal && object.meanShare < kWeakShare)
        object.faults.push_back(
            scene.statistics.capFactor < 1.0
                ? fmt::format(
                      "{} holds it at {:.0f} % of its pressure", cap, 100.0 * object.meanShare)
                : fmt::format("the array reaches {:.0f} % of its pressure in the mean",
                              100.0 * object.meanShare));
    else if (!isPascal && !object.hasOwnPressures && object.property.pressure > kLargeRelative)
        object.notes.push_back(
            fmt::format("its pressure of {:g} is relative to that of other objects; in Pa it needs "
                        "a unit: 500 Pa in a tag or an option, PressureUnit PASCAL in a node",
                        object.property.pressure));
    else if (!isPascal && scene.statistics.capFactor < 1.0)
        object.notes.push_back(cap + " makes it quieter");
}

} // namespace

std::string pressureText(const CheckedObject& object)
{
    const osgMidair::HapticProperty& property = object.property;
    if (!property.whySilenced.empty()) return "what isn't understood";
    if (object.hasOwnPressures) return "a pressure for each point";
    return property.pressureUnit == osgMidair::HapticProperty::PASCAL
               ? fmt::format("{:g} Pa", property.pressure)
               : fmt::format("{:g} (relative)", property.pressure);
}

std::string whyNothing(const CheckedScene& scene)
{
    if (!scene.asked.enabled) return "the scene is not enabled";
    if (!scene.hiddenBy.empty()) return "the scene is hidden by " + scene.hiddenBy;
    return scene.messages.empty() ? "nothing in it is marked as haptic" : "the messages say why";
}

void judge(CheckedObject& object, const CheckedScene& scene, int frames)
{
    if (!object.property.enabled)
    {
        object.notes.push_back("it is not enabled");
        return;
    }
    const osgMidair::HapticField::Object& out = object.leftOut;
    const std::vector<std::string> large =
        toldOf(object, scene, {"object.large", "object.units", "object.small"});
    // Hands that come and go, and animation, make an object felt in some frames only.
    if (object.points == 0 && object.feltFrames == 0)
        judgeUnfelt(object, scene);
    else if (object.feltFrames > 0 && object.feltFrames < frames)
        object.notes.push_back(
            fmt::format("it is felt in {} of {} frames", object.feltFrames, frames));
    // Of what is simply too large or too small, that is the one cause.
    if (object.points > 0) append(object.faults, large);
    if (out.outOfWorkspace > 0 && large.empty())
        object.faults.push_back(points(out.outOfWorkspace, "they are out of the workspace"));
    if (out.overBudget > 0 && large.empty())
        object.faults.push_back(points(out.overBudget, "there are more than maxPoints"));
    if (out.invalid > 0) object.faults.push_back(points(out.invalid, "they are not finite"));
    if (out.crowded > 0) object.notes.push_back(points(out.crowded, "others are too near"));
    if (out.unpainted > 0) object.notes.push_back(points(out.unpainted, "intensity 0"));
    if (out.outOfReach > 0) object.notes.push_back(points(out.outOfReach, "no hand is near"));
    if (object.points > 0) judgePressure(object, scene);
}

int CheckResult::exitCode() const
{
    bool isFine = std::none_of(reading.begin(), reading.end(), isBad);
    for (const CheckedScene& scene : scenes)
    {
        isFine = isFine && std::none_of(scene.messages.begin(), scene.messages.end(), isBad) &&
                 std::all_of(scene.objects.begin(),
                             scene.objects.end(),
                             [](const CheckedObject& object) { return object.faults.empty(); });
    }
    // Another scene plays what is inside it.
    const auto isFelt = [](const CheckedScene& scene)
    { return scene.isInside || !scene.objects.empty(); };
    const bool isAnyFelt =
        !scenes.empty() && std::all_of(scenes.begin(), scenes.end(), isFelt) &&
        std::any_of(scenes.begin(),
                    scenes.end(),
                    [](const CheckedScene& scene) { return !scene.objects.empty(); });
    return isFine && isAnyFelt ? 0 : 1;
}

} // namespace midair::samples
