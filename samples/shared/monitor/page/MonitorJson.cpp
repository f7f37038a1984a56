#include "samples/shared/monitor/page/MonitorJson.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace midair::samples
{

namespace
{

using Json = nlohmann::ordered_json;
using osgMidair::HapticStatistics;

/// Text of JSON for any bytes.
std::string dumped(const Json& json)
{
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json arrayJson(const MonitorState& state)
{
    const MonitorReading& reading = state.view.reading;
    const HapticStatistics& s = reading.statistics;
    return {{"state", midair::bridge::stateName(s.state)},
            {"since_s", state.now_s - state.view.state_s},
            {"isMuted", reading.isMuted},
            {"array", reading.array},
            {"transducers", s.transducers},
            {"device", s.device},
            {"objects", s.objects},
            {"points", s.points},
            {"hands", s.hands},
            {"touching", s.touching},
            {"temperature_C", s.temperature_C}};
}

/// How well the newest field is as wanted; null before the first.
Json errorJson(const HapticStatistics& s)
{
    if (s.figures.empty()) return nullptr;
    Json json = {{"rms", s.rms},
                 {"max", s.max},
                 {"level_Pa", s.level_Pa},
                 {"capFactor", s.capFactor},
                 {"leftOut", s.leftOut},
                 {"stop", s.stop},
                 {"fieldsInTurn", s.fieldsInTurn},
                 {"updatesPerSecond", s.updatesPerSecond}};
    for (const auto& [name, value] : s.figures)
        if (!json.contains(name)) json[name] = value;
    return json;
}

Json exposureOf(const HapticStatistics& s)
{
    Json json = {{"what", midair::haptics::kExposureMeaning}};
    for (const midair::haptics::ExposureRow& row : midair::haptics::kExposureFigures)
        std::visit([&](auto member) { json[row.name] = s.exposure.*member; }, row.value);
    return json;
}

Json fieldsOf(const osgMidair::ArrayFields& fields)
{
    Json json = Json::object();
    for (const osgMidair::ArrayFieldsRow& row : osgMidair::kArrayFields)
        json[row.name] = fields.*row.value;
    return json;
}

Json countersOf(const HapticStatistics& s)
{
    Json json = Json::object();
    for (const midair::bridge::CounterRow& row : midair::bridge::kHologramCounters)
        json[row.name] = s.*row.value;
    return json;
}

/// The gravest first.
Json messagesOf(const HapticStatistics& s)
{
    std::vector<osgMidair::HapticMessage> sorted = s.told;
    std::stable_sort(sorted.begin(),
                     sorted.end(),
                     [](const auto& a, const auto& b) { return a.severity > b.severity; });
    Json json = Json::array();
    for (const osgMidair::HapticMessage& message : sorted)
        json.push_back({{"severity", kSeverityNames.at(message.severity)},
                        {"code", message.code},
                        {"path", message.path},
                        {"text", message.text},
                        {"count", message.count}});
    return json;
}

Json eventsOf(const MonitorState& state)
{
    Json json = Json::array();
    for (const MonitorEvent& event : state.view.events)
        json.push_back(
            {{"age_s", state.now_s - event.time_s}, {"text", event.text}, {"count", event.count}});
    return json;
}

} // namespace

std::string statusJson(const MonitorState& state)
{
    const HapticStatistics& s = state.view.reading.statistics;
    const bool isOld = state.isOld();
    Json json = {{"name", state.name},
                 {"reading",
                  {{"isOld", isOld},
                   {"age_s", state.view.isRead ? Json(state.now_s - state.view.read_s) : Json()}}},
                 {"frames",
                  {{"count", s.frames},
                   {"isStanding", state.isStanding()},
                   {"age_s", state.view.isRead ? Json(state.now_s - state.view.frame_s) : Json()},
                   {"perSecond", state.isStanding() ? 0.0 : state.view.framesPerSecond}}}};
    json["array"] = isOld ? Json() : arrayJson(state);
    json["error"] = isOld ? Json() : errorJson(s);
    json["latency_ms"] =
        isOld || s.figures.empty()
            ? Json()
            : Json{{"last", s.latency_ms}, {"p50", s.latencyP50_ms}, {"p99", s.latencyP99_ms}};
    json["exposure"] = isOld ? Json() : exposureOf(s);
    json["fields"] = isOld ? Json() : fieldsOf(s.fields);
    json["counters"] = isOld ? Json() : countersOf(s);
    json["messages"] = isOld ? Json() : messagesOf(s);
    json["mute"] = state.view.mutedBy.empty() ? Json()
                                              : Json{{"by", state.view.mutedBy},
                                                     {"age_s", state.now_s - state.view.muted_s}};
    json["events"] = eventsOf(state);
    json["picture"] = {{"problem", state.picture.problem},
                       {"count", state.picture.count},
                       {"readback_ms", state.picture.last_ms},
                       {"mostReadback_ms", state.picture.most_ms}};
    return dumped(json);
}

std::string muteJson(bool muted, const MuteOutcome& outcome)
{
    return dumped({{"isMuted", muted},
                   {"isConfirmed", outcome.isConfirmed},
                   {"state", midair::bridge::stateName(outcome.state)},
                   {"took_ms", outcome.took_ms}});
}

std::string healthProblem(const MonitorState& state)
{
    if (!state.view.isRead) return "nothing was read yet";
    if (state.isOld())
        return fmt::format("nothing was read for {:.1f} s: the program hangs",
                           state.now_s - state.view.read_s);
    if (state.isStanding())
        return fmt::format("no frame for {:.1f} s: the frame loop stands still",
                           state.now_s - state.view.frame_s);
    using osgMidair::ArrayState;
    const ArrayState array = state.view.reading.statistics.state;
    if (array == ArrayState::CLOSED || array == ArrayState::LOST || array == ArrayState::FAULT)
        return fmt::format("the array is {}", midair::bridge::stateName(array));
    return {};
}

} // namespace midair::samples
