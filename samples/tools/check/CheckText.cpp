#include "samples/tools/check/CheckReport.h"

#include <iterator>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

using Out = std::back_insert_iterator<std::string>;

std::string orNone(const std::string& text)
{
    return text.empty() ? "none" : text;
}

/// "usb: (not granted: sim:)", or one of both if they are the same.
std::string wish(const std::string& asked, const std::string& granted)
{
    return asked == granted
               ? orNone(asked)
               : fmt::format("asks for {}, would get {}", orNone(asked), orNone(granted));
}

void printObject(Out out, const CheckedObject& object, int frames)
{
    fmt::format_to(out, "  object {}\n", object.path);
    fmt::format_to(out,
                   "    points    {}; felt in {} of {} frames\n",
                   object.points,
                   object.feltFrames,
                   frames);
    fmt::format_to(out, "    asked     {}\n", pressureText(object));
    if (object.points > 0 && object.highest_Pa <= 0.0)
        fmt::format_to(out, "    plays     nothing\n");
    else if (object.points > 0)
        fmt::format_to(out,
                       "    plays     {:.0f} Pa in the mean, {:.0f} .. {:.0f} Pa: {:.1f} % of what "
                       "is wanted, at "
                       "least {:.1f} %\n",
                       object.mean_Pa,
                       object.lowest_Pa,
                       object.highest_Pa,
                       100.0 * object.meanShare,
                       100.0 * object.lowestShare);
    if (object.points > 0)
    {
        const osg::Vec3d centre = object.centre_m * 1e3;
        const osg::Vec3d size = object.size_m * 1e3;
        fmt::format_to(
            out,
            "    place     {:.1f} {:.1f} {:.1f} mm in the array's frame, {:.1f} x {:.1f} "
            "x {:.1f} mm\n",
            centre.x(),
            centre.y(),
            centre.z(),
            size.x(),
            size.y(),
            size.z());
    }
    if (object.property.touchEvents)
        fmt::format_to(out, "    touched   in {} of {} frames\n", object.touchFrames, frames);
    for (const std::string& fault : object.faults)
        fmt::format_to(out, "    FAULT     {}\n", fault);
    for (const std::string& note : object.notes)
        fmt::format_to(out, "    note      {}\n", note);
}

void printMessage(Out out, const CheckedMessage& one)
{
    const osgMidair::HapticMessage& message = one.message;
    fmt::format_to(
        out, "  {:<7} {}: {}", severityName(message.severity), message.code, message.text);
    if (message.count > 1) fmt::format_to(out, " ({} times)", message.count);
    if (one.line > 0) fmt::format_to(out, " [{}:{}]", one.file, one.line);
    fmt::format_to(out, "\n");
}

void printScene(Out out, const CheckedScene& scene, int frames)
{
    const osgMidair::HapticStatistics& s = scene.statistics;
    fmt::format_to(out, "HapticScene{}\n", scene.name.empty() ? "" : " '" + scene.name + "'");
    if (scene.isInside)
    {
        for (const CheckedMessage& message : scene.messages)
            printMessage(out, message);
        return;
    }
    fmt::format_to(out, "  array     {}\n", wish(scene.asked.array, scene.granted.array));
    if (scene.transducers > 0)
        fmt::format_to(
            out,
            "            {} transducers, {:.0f} x {:.0f} x {:.0f} mm; it reaches {:.0f} mm\n",
            scene.transducers,
            1e3 * scene.arraySize_m.x(),
            1e3 * scene.arraySize_m.y(),
            1e3 * scene.arraySize_m.z(),
            1e3 * scene.reach_m);
    fmt::format_to(out, "  device    {}\n", wish(scene.asked.device, scene.granted.device));
    fmt::format_to(out, "            here: {}\n", orNone(s.device));
    fmt::format_to(out, "  hands     {}\n", wish(scene.asked.hands, scene.granted.hands));
    fmt::format_to(out,
                   "  field     {}: {} points, {:.0f} Pa, rms {:.3f} %, cap {}{}\n",
                   stateName(s.state),
                   s.points,
                   s.level_Pa,
                   100.0 * s.rms,
                   s.maxPressure_Pa > 0.0 ? fmt::format("{:.4g} Pa", s.maxPressure_Pa) : "none",
                   scene.granted.earLimit > 0.0
                       ? fmt::format(", at ears {:g} dB", scene.granted.earLimit)
                       : "");
    if (s.exposure.places > 0)
        fmt::format_to(out,
                       "  ears      {:.0f} dB at the loudest place around the array, {:g} dB of it "
                       "for a head\n",
                       s.exposure.level_dB,
                       s.exposure.head_dB);
    if (scene.objects.empty())
        fmt::format_to(out, "  FAULT     nothing is felt: {}\n", whyNothing(scene));
    for (const CheckedObject& object : scene.objects)
        printObject(out, object, frames);
    for (const CheckedMessage& message : scene.messages)
        printMessage(out, message);
}

} // namespace

const char* severityName(osgMidair::HapticMessage::Severity severity)
{
    constexpr const char* kNames[] = {"notice", "warning", "fault"};
    return kNames[severity];
}

std::string checkText(const CheckResult& result)
{
    std::string text;
    const Out out = std::back_inserter(text);
    fmt::format_to(out,
                   "{}: {}\n",
                   result.file,
                   result.exitCode() == 0 ? "is felt as it asks for"
                                          : "is not felt as it asks for, or not all of it");
    if (!result.wrapped.empty()) fmt::format_to(out, "  {}\n", result.wrapped);
    for (const CheckedMessage& message : result.reading)
        printMessage(out, message);
    for (const CheckedScene& scene : result.scenes)
        printScene(out, scene, result.frames);
    return text;
}

} // namespace midair::samples
