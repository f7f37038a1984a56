#include "samples/tools/check/CheckReport.h"

#include <nlohmann/json.hpp>

namespace midair::samples
{

namespace
{

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
                 {"count", message.count}};
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
        {"faults", object.faults},
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

} // namespace

std::string checkJson(const CheckResult& result)
{
    Json scenes = Json::array();
    for (const CheckedScene& scene : result.scenes)
        scenes.push_back(sceneJson(scene));
    const Json json = {{"file", result.file},
                       {"exitCode", result.exitCode()},
                       {"frames", result.frames},
                       {"wrapped", result.wrapped},
                       {"reading", messagesJson(result.reading)},
                       {"scenes", std::move(scenes)}};
    // What a file names may be no UTF-8.
    return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

} // namespace midair::samples
