// Lists each touchable object of a scene file or a model with its place and strength, and explains
// what is wrong with the others, without a window and without hardware.
#include "samples/shared/ModelAxes.h"
#include "samples/shared/ToolOptions.h"
#include "samples/tools/check/SceneCheck.h"

#include <osgMidair/FileFormats>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <iterator>
#include <string>

#include <CLI/CLI.hpp>
#include <fcntl.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

namespace
{

using namespace midair;
using namespace midair::samples;

/// "notice", "warning" or "fault".
const char* severityName(osgMidair::HapticMessage::Severity severity)
{
    constexpr const char* kNames[] = {"notice", "warning", "fault"};
    return kNames[severity];
}

using Out = std::back_insert_iterator<std::string>;

std::string orNone(const std::string& text)
{
    return text.empty() ? "none" : text;
}

/// Returns "asks for usb:, would get sim:", or just one of them if they are equal.
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
    fmt::format_to(out, "    pressure  {}\n", pressureText(object));
    if (object.points > 0 && object.highest_Pa <= 0.0)
        fmt::format_to(out, "    plays     nothing\n");
    else if (object.points > 0)
        fmt::format_to(out,
                       "    plays     {:.0f} Pa on average, {:.0f} .. {:.0f} Pa: {:.1f} % of what "
                       "was asked for (at the weakest point {:.1f} %)\n",
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
    if (!object.feeling.empty())
        fmt::format_to(
            out, "    a finger  gets up to {:.2g} mN: {}\n", 1e3 * object.force_N, object.feeling);
    for (const std::string& fault : object.faults)
        fmt::format_to(out, "    FAULT     {}\n", fault);
    for (const std::string& warning : object.warnings)
        fmt::format_to(out, "    warning   {}\n", warning);
    for (const std::string& note : object.notes)
        fmt::format_to(out, "    note      {}\n", note);
}

void printMessage(Out out, const CheckedMessage& one)
{
    const osgMidair::HapticMessage& message = one.message;
    fmt::format_to(
        out, "  {:<7} {}: {}", severityName(message.severity), message.code, message.text);
    if (message.count > 1) fmt::format_to(out, " ({} times)", message.count);
    if (message.until_s > 0.0) fmt::format_to(out, " (over)");
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
            "            {} transducers, {:.0f} x {:.0f} x {:.0f} mm, felt up to {:.0f} mm away\n",
            scene.transducers,
            1e3 * scene.arraySize_m.x(),
            1e3 * scene.arraySize_m.y(),
            1e3 * scene.arraySize_m.z(),
            1e3 * scene.reach_m);
    fmt::format_to(out, "  device    {}\n", wish(scene.asked.device, scene.granted.device));
    fmt::format_to(out, "            here: {}\n", orNone(s.device));
    fmt::format_to(out, "  hands     {}\n", wish(scene.asked.hands, scene.granted.hands));
    fmt::format_to(
        out,
        "  field     {}: {} points, {}, cap {}{}\n",
        stateName(s.state),
        s.points,
        s.evened ? fmt::format("evened out over the surface: {:.1f} Pa of radiation pressure "
                               "on average, give or take {:.0f} %",
                               s.surface.mean_Pa,
                               100.0 * s.surface.coefficientOfVariation)
                 : fmt::format("{:.0f} Pa, rms error {:.3f} %", s.level_Pa, 100.0 * s.rms),
        s.maxPressure_Pa > 0.0 ? fmt::format("{:.4g} Pa", s.maxPressure_Pa) : "none",
        scene.granted.earLimit > 0.0 ? fmt::format(", at ears {:g} dB", scene.granted.earLimit)
                                     : "");
    if (s.reflectorCount > 0)
        fmt::format_to(
            out,
            "  mirrors   {} reflector{} in all figures; off by their accuracy they leave "
            "an rms error of {}\n",
            s.reflectorCount,
            s.reflectorCount == 1 ? "" : "s",
            s.reflectorRms > 0.0 ? fmt::format("{:.3f} %", 100.0 * s.reflectorRms)
                                 : "unknown size, as the field didn't rest");
    if (s.exposure.places > 0)
        fmt::format_to(out,
                       "  ears      {:.0f} dB at the loudest place around the array, including "
                       "{:g} dB for a head\n",
                       s.exposure.level_dB,
                       s.exposure.head_dB);
    if (scene.objects.empty())
        fmt::format_to(out, "  FAULT     nothing is felt: {}\n", whyNothing(scene));
    for (const CheckedObject& object : scene.objects)
        printObject(out, object, frames);
    for (const CheckedMessage& message : scene.messages)
        printMessage(out, message);
}

using Json = nlohmann::ordered_json;

Json vectorJson(const osg::Vec3d& vector)
{
    return {vector.x(), vector.y(), vector.z()};
}

Json messageJson(const CheckedMessage& one)
{
    const osgMidair::HapticMessage& message = one.message;
    Json json = {{"severity", severityName(message.severity)},
                 {"code", message.code},
                 {"path", message.path},
                 {"text", message.text},
                 {"count", message.count},
                 {"active", message.isActive}};
    if (one.line == 0) return json;
    json["file"] = one.file;
    json["line"] = one.line;
    return json;
}

Json messagesJson(const std::vector<CheckedMessage>& messages)
{
    Json json = Json::array();
    for (const CheckedMessage& message : messages)
        json.push_back(messageJson(message));
    return json;
}

Json objectJson(const CheckedObject& object)
{
    const osgMidair::HapticField::Object& out = object.leftOut;
    return {
        {"path", object.path},
        {"name", object.name},
        {"enabled", object.property.enabled},
        {"asked",
         {{"pressure", object.property.pressure},
          {"eachPoint", object.hasOwnPressures},
          {"unit",
           object.property.pressureUnit == osgMidair::HapticProperty::PASCAL ? "Pa" : "relative"}}},
        {"points", object.points},
        {"wanted_Pa", object.wanted_Pa},
        {"share", {{"lowest", object.lowestShare}, {"mean", object.meanShare}}},
        {"played_Pa",
         {{"lowest", object.lowest_Pa}, {"mean", object.mean_Pa}, {"highest", object.highest_Pa}}},
        {"centre_m", vectorJson(object.centre_m)},
        {"size_m", vectorJson(object.size_m)},
        {"feltFrames", object.feltFrames},
        {"touchFrames", object.touchFrames},
        {"leftOut",
         {{"outOfWorkspace", out.outOfWorkspace},
          {"overBudget", out.overBudget},
          {"crowded", out.crowded},
          {"unpainted", out.unpainted},
          {"invalid", out.invalid},
          {"outOfReach", out.outOfReach}}},
        {"unreachable", out.isUnreachable},
        {"verdict", verdictName(object.verdict())},
        {"fingertip_N", object.force_N},
        {"feeling", object.feeling},
        {"faults", object.faults},
        {"warnings", object.warnings},
        {"notes", object.notes}};
}

Json wishJson(const std::string& asked, const std::string& granted)
{
    return {{"asked", asked}, {"granted", granted}};
}

Json sceneJson(const CheckedScene& scene)
{
    const osgMidair::HapticStatistics& s = scene.statistics;
    Json objects = Json::array();
    for (const CheckedObject& object : scene.objects)
        objects.push_back(objectJson(object));
    Json json = {{"name", scene.name},
                 {"inside", scene.isInside},
                 {"unfelt", scene.objects.empty() && !scene.isInside ? whyNothing(scene) : ""},
                 {"array", wishJson(scene.asked.array, scene.granted.array)},
                 {"device", wishJson(scene.asked.device, scene.granted.device)},
                 {"hands", wishJson(scene.asked.hands, scene.granted.hands)},
                 {"deviceStatus", s.device},
                 {"state", stateName(s.state)},
                 {"points", s.points},
                 {"level_Pa", s.level_Pa},
                 {"rms", s.rms},
                 {"reflectorCount", s.reflectorCount},
                 {"reflectorRms", s.reflectorRms},
                 {"evened", s.evened},
                 {"maxPressure_Pa", s.maxPressure_Pa},
                 {"capFactor", s.capFactor},
                 {"stop", s.stop}};
    json["array"]["transducers"] = scene.transducers;
    json["array"]["size_m"] = vectorJson(scene.arraySize_m);
    json["array"]["reach_m"] = scene.reach_m;
    json["objects"] = std::move(objects);
    json["messages"] = messagesJson(scene.messages);
    return json;
}

/// Returns the text after an object's name in the list of verdicts.
std::string lineOf(const CheckedObject& object)
{
    if (!object.faults.empty()) return object.faults.front();
    if (!object.warnings.empty()) return object.warnings.front();
    if (object.points == 0) return object.notes.empty() ? "" : object.notes.front();
    return fmt::format("{:.0f} Pa at {} point{}; a fingertip gets up to {:.2g} mN: {}",
                       object.mean_Pa,
                       object.points,
                       object.points == 1 ? "" : "s",
                       1e3 * object.force_N,
                       object.feeling);
}

/// Returns the report as text: the verdict, a line for each object, then the details.
std::string checkText(const CheckResult& result)
{
    std::string text;
    const Out out = std::back_inserter(text);
    fmt::format_to(
        out, "{}: {}: {}\n", verdictName(result.verdict()), result.file, result.because());
    if (!result.remedy.empty()) fmt::format_to(out, "  try: {}\n", result.remedy);
    for (const CheckedScene& scene : result.scenes)
        for (const CheckedObject& object : scene.objects)
            fmt::format_to(out,
                           "  {:<8} {}: {}\n",
                           verdictName(object.verdict()),
                           object.path,
                           lineOf(object));
    fmt::format_to(out, "\n");
    if (!result.wrapped.empty()) fmt::format_to(out, "  {}\n", result.wrapped);
    if (const std::string axes = turnedAxes(result.file, result.options); !axes.empty())
        fmt::format_to(out, "  {}\n", axes);
    for (const CheckedMessage& message : result.reading)
        printMessage(out, message);
    for (const CheckedScene& scene : result.scenes)
        printScene(out, scene, result.frames);
    return text;
}

/// Returns the report as JSON.
std::string checkJson(const CheckResult& result)
{
    Json scenes = Json::array();
    for (const CheckedScene& scene : result.scenes)
        scenes.push_back(sceneJson(scene));
    const Json json = {{"file", result.file},
                       {"verdict", verdictName(result.verdict())},
                       {"because", result.because()},
                       {"remedy", result.remedy},
                       {"exitCode", result.exitCode()},
                       {"frames", result.frames},
                       {"wrapped", result.wrapped},
                       {"reading", messagesJson(result.reading)},
                       {"scenes", std::move(scenes)}};
    // Names in a file may not be valid UTF-8.
    return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

/// Redirects stdout to stderr, so that output of plugins does not mix with the report.
class OwnOutput
{
public:
    OwnOutput() : _before(::dup(STDOUT_FILENO))
    {
        std::fflush(stdout);
        ::dup2(STDERR_FILENO, STDOUT_FILENO);
    }
    ~OwnOutput()
    {
        std::fflush(stdout);
        std::cout.flush();
        ::dup2(_before, STDOUT_FILENO);
        ::close(_before);
    }
    OwnOutput(const OwnOutput&) = delete;
    OwnOutput& operator=(const OwnOutput&) = delete;

private:
    int _before;
};

/// Reads the file in a trial process for osgMidair::readModel(). On success sends one byte to the
/// inherited socket; a crash or an exception of the reader ends only this process.
[[noreturn]] void tryToRead(const midair::samples::CheckOptions& options)
try
{
    constexpr int kSocket = 3;
    const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    ::dup2(nowhere, STDOUT_FILENO);
    ::dup2(nowhere, STDERR_FILENO);
    const rlimit none{};
    ::setrlimit(RLIMIT_CORE, &none);
    osgMidair::readModelOnTrial(options.file, new osgDB::Options(options.options));
    ::send(kSocket, "1", 1, MSG_NOSIGNAL);
    ::_exit(0);
}
catch (...)
{
    std::abort();
}

int run(int argc, char** argv)
{
    CheckOptions options;
    bool json = false;
    bool isTrial = false;
    CLI::App app(
        "Lists each touchable object of a scene or a model with its place and strength, and "
        "explains what is wrong with the others.\n"
        "Example: midair-check model.obj.haptic -O size=0.08\n"
        "It never opens hardware: fields are simulated, and only recorded hands are read.\n"
        "Exit code: 0 OK or WARNING, 1 PROBLEM, 2 the file can't be read or an option is wrong.",
        "midair-check");
    app.add_option(
           "scene", options.file, "scene or model, as osgviewer reads it (MODEL.haptic too)")
        ->required();
    app.add_option(
        "--device", options.settings, "file of settings, as for osgviewer's --device FILE.haptic");
    app.add_option("-O,--options", options.options, "options, as for osgviewer's -O");
    app.add_option("--frames", options.frames, "frames to play, at 60 per second")
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
    app.add_option("--wait", options.wait_s, "timeout for the field of one frame, s")
        ->check(CLI::Range(0.001, 3600.0))
        ->capture_default_str();
    app.add_flag("--json", json, "print the report as JSON");
    app.add_flag("--try", isTrial)->group("");
    useToolHelp(app);
    try
    {
        app.parse(argc, argv);
        if (isTrial) tryToRead(options);
        const CheckResult result = [&options]
        {
            const OwnOutput others;
            return checkScene(options);
        }();
        std::puts((json ? checkJson(result) : checkText(result)).c_str());
        return result.exitCode();
    }
    catch (const CLI::ParseError& error)
    {
        return exitOf(app, error);
    }
}

} // namespace

int main(int argc, char** argv)
{
    try
    {
        return run(argc, argv);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "midair-check: %s\n", error.what());
        return EXIT_WRONG;
    }
}
