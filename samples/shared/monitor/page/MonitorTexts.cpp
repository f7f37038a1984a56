#include "samples/shared/monitor/page/MonitorTexts.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace midair::samples
{

namespace
{

using Json = nlohmann::ordered_json;
using osgMidair::ArrayState;
using osgMidair::HapticStatistics;

/// By HapticMessage::Severity.
constexpr std::array kSeverityNames = {"notice", "warning", "fault"};

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

/// Returns "meanPhaseStep_rad" as "mean_phase_step_radians"; \a factor is what its values are to be
/// multiplied with: milliseconds become seconds.
std::string metricName(const std::string& figure, double& factor)
{
    struct Unit
    {
        std::string_view ending;
        std::string_view name;
        double factor;
    };
    constexpr std::array<Unit, 8> kUnits = {{{"_Pa", "_pascals", 1.0},
                                             {"_ms", "_seconds", 1e-3},
                                             {"_s", "_seconds", 1.0},
                                             {"_rad", "_radians", 1.0},
                                             {"_m", "_meters", 1.0},
                                             {"_dB", "_decibels", 1.0},
                                             {"_C", "_celsius", 1.0},
                                             {"_Hz", "_hertz", 1.0}}};
    factor = 1.0;
    std::string_view stem = figure;
    std::string_view unit;
    for (const Unit& each : kUnits)
        if (const std::size_t at = stem.size() - each.ending.size();
            stem.size() > each.ending.size() && stem.substr(at) == each.ending)
        {
            stem.remove_suffix(each.ending.size());
            unit = each.name;
            factor = each.factor;
            break;
        }
    std::string name;
    for (const char c : stem)
    {
        const auto letter = static_cast<unsigned char>(c);
        if (std::isupper(letter) != 0) name += '_';
        name += std::isalnum(letter) != 0 ? static_cast<char>(std::tolower(letter)) : '_';
    }
    return name.append(unit);
}

/// Calls \a take with the name and the number of each figure of the exposure.
template<typename Take>
void eachExposure(const midair::haptics::ExposureFigures& exposure, const Take& take)
{
    for (const midair::haptics::ExposureRow& row : midair::haptics::kExposureFigures)
        std::visit([&](auto member) { take(row.name, exposure.*member); }, row.value);
}

/// What the newest reading said.
void addReading(Json& json, const MonitorState& state)
{
    const HapticStatistics& s = state.view.reading.statistics;
    json["array"] = arrayJson(state);
    json["error"] = errorJson(s);
    if (!s.figures.empty())
        json["latency_ms"] = {
            {"last", s.latency_ms}, {"p50", s.latencyP50_ms}, {"p99", s.latencyP99_ms}};
    json["exposure"] = {{"what", midair::haptics::kExposureMeaning}};
    eachExposure(s.exposure, [&](const char* name, auto value) { json["exposure"][name] = value; });
    json["fields"] = Json::object();
    for (const osgMidair::ArrayFieldsRow& row : osgMidair::kArrayFields)
        json["fields"][row.name] = s.fields.*row.value;
    json["counters"] = Json::object();
    for (const midair::bridge::CounterRow& row : midair::bridge::kHologramCounters)
        json["counters"][row.name] = s.*row.value;
    std::vector<osgMidair::HapticMessage> gravestFirst = s.told;
    std::stable_sort(gravestFirst.begin(),
                     gravestFirst.end(),
                     [](const auto& a, const auto& b) {
                         return std::make_pair(a.isActive, a.severity) >
                                std::make_pair(b.isActive, b.severity);
                     });
    json["messages"] = Json::array();
    for (const osgMidair::HapticMessage& message : gravestFirst)
        json["messages"].push_back({{"severity", kSeverityNames.at(message.severity)},
                                    {"code", message.code},
                                    {"path", message.path},
                                    {"text", message.text},
                                    {"count", message.count},
                                    {"active", message.isActive},
                                    {"since_s", message.since_s},
                                    {"until_s", message.until_s}});
}

/// Writes metrics, each with its two lines of comment before it.
class MetricLines
{
public:
    template<typename Number>
    void gauge(const std::string& name, std::string_view help, Number value)
    {
        begin(name, help, "gauge");
        sample(name, {}, static_cast<double>(value));
    }
    /// \a name without "_total".
    template<typename Number>
    void counter(const std::string& name, std::string_view help, Number value)
    {
        begin(name + "_total", help, "counter");
        sample(name + "_total", {}, static_cast<double>(value));
    }
    /// A gauge whose name ends as that of a figure, in Prometheus' units.
    template<typename Number>
    void figure(const std::string& before,
                const std::string& figure,
                std::string_view help,
                Number value)
    {
        double factor = 1.0;
        const std::string name = metricName(figure, factor);
        gauge(before + name, help, factor * static_cast<double>(value));
    }
    void begin(const std::string& name, std::string_view help, const char* type)
    {
        _text += fmt::format("# HELP {0} {1}\n# TYPE {0} {2}\n", name, help, type);
    }
    void sample(const std::string& name, const std::string& labels, double value)
    {
        const std::string number = std::isnan(value)   ? "NaN"
                                   : std::isinf(value) ? (value > 0.0 ? "+Inf" : "-Inf")
                                                       : fmt::format("{}", value);
        _text += name + (labels.empty() ? "" : "{" + labels + "}") + " " + number + "\n";
    }
    std::string take() { return std::move(_text); }

private:
    std::string _text;
};

void addPage(MetricLines& lines, const MonitorState& state)
{
    lines.gauge("midair_up",
                "1: the installation can be read; 0: it hangs, and nothing else is known of it.",
                state.isOld() ? 0.0 : 1.0);
    if (state.view.isRead)
    {
        lines.gauge("midair_reading_age_seconds",
                    "How old the newest reading of the installation is.",
                    state.now_s - state.view.read_s);
        lines.gauge("midair_frame_age_seconds",
                    "Time since the scene was last updated.",
                    state.now_s - state.view.frame_s);
        lines.counter(
            "midair_frames", "Updates of the scene.", state.view.reading.statistics.frames);
    }
    lines.begin(
        "midair_page_answers_total", "Answers to whole requests by HTTP status.", "counter");
    for (const auto& [status, count] : state.answers)
        lines.sample("midair_page_answers_total",
                     fmt::format("code=\"{}\"", status),
                     static_cast<double>(count));
    lines.counter("midair_page_pictures", "Pictures taken for the page.", state.picture.count);
    lines.counter("midair_page_picture_readback_seconds",
                  "Time that the thread that draws has spent on pictures for the page.",
                  1e-3 * state.picture.sum_ms);
}

/// Returns which device it is, without what changes: counters and why it could not be opened.
std::string deviceOf(const HapticStatistics& s)
{
    if (s.state == ArrayState::CLOSED || s.state == ArrayState::OPENING) return "not open";
    return s.device.substr(0, s.device.find_first_of(",;"));
}

void addArray(MetricLines& lines, const MonitorState& state)
{
    const HapticStatistics& s = state.view.reading.statistics;
    lines.begin(
        "midair_array_state", "1 for the state that the array is in, 0 for others.", "gauge");
    for (int i = 0; i <= static_cast<int>(ArrayState::FAULT); ++i)
    {
        const auto each = static_cast<ArrayState>(i);
        lines.sample("midair_array_state",
                     fmt::format("state=\"{}\"", midair::bridge::stateName(each)),
                     each == s.state ? 1.0 : 0.0);
    }
    lines.begin("midair_array_info", "Always 1; says which array and device it is.", "gauge");
    lines.sample("midair_array_info",
                 fmt::format("name=\"{}\",array=\"{}\",device=\"{}\"",
                             labelValue(state.name),
                             labelValue(state.view.reading.array),
                             labelValue(deviceOf(s))),
                 1.0);
    lines.gauge("midair_muted", "1: a mute is asked for.", state.view.reading.isMuted ? 1.0 : 0.0);
    lines.gauge("midair_air_temperature_celsius", "That fields are solved for.", s.temperature_C);
    lines.gauge("midair_objects", "Objects that are felt now.", s.objects);
    lines.gauge("midair_hands", "Hands that are tracked now.", s.hands);
    lines.gauge("midair_pressure_cap_pascals",
                "Cap of the peak pressure at control points; 0: none.",
                s.maxPressure_Pa);
    for (const midair::bridge::ArrayFieldsRow& row : midair::bridge::kArrayFields)
    {
        using Row = midair::bridge::ArrayFieldsRow;
        const std::string name =
            std::string(row.of == Row::DEVICE ? "midair_device_" : "midair_fields_") + row.name;
        if (row.of == Row::NOW)
            lines.gauge(name, row.help, s.fields.*row.value);
        else
            lines.counter(name, row.help, s.fields.*row.value);
    }
}

void addField(MetricLines& lines, const HapticStatistics& s)
{
    lines.gauge(
        "midair_field_updates_hertz", "Fields solved in the last second.", s.updatesPerSecond);
    if (s.figures.empty()) return;
    lines.gauge("midair_latency_seconds",
                "From the frame's stamp to the drive signal, of the newest field.",
                1e-3 * s.latency_ms);
    lines.gauge(
        "midair_latency_median_seconds", "Median of the last 1024 fields.", 1e-3 * s.latencyP50_ms);
    lines.gauge("midair_latency_p99_seconds",
                "99th percentile of the last 1024 fields.",
                1e-3 * s.latencyP99_ms);
    for (const auto& [figure, value] : s.figures)
        lines.figure("midair_field_",
                     figure,
                     figure == "rms"
                         ? "Relative rms error of the pressures at the control points; while the "
                           "array doesn't play, of a field that nobody feels."
                         : fmt::format("Figure {} of the newest field.", figure),
                     value);
}

void addExposure(MetricLines& lines, const midair::haptics::ExposureFigures& exposure)
{
    if (exposure.places == 0) return;
    eachExposure(exposure,
                 [&](const char* name, auto value)
                 {
                     lines.figure("midair_exposure_",
                                  name,
                                  fmt::format("Figure {} of the level at ears, computed, with {:g} "
                                              "dB for a head; not a safety certificate.",
                                              name,
                                              midair::haptics::kHeadMargin_dB),
                                  value);
                 });
}

void addCounts(MetricLines& lines, const MonitorView& view)
{
    for (const midair::bridge::CounterRow& row : midair::bridge::kHologramCounters)
    {
        double factor = 1.0;
        lines.counter("midair_pipeline_" + metricName(row.name, factor),
                      fmt::format("Counter {} of the pipeline.", row.name),
                      view.reading.statistics.*row.value);
    }
    if (view.messages.empty()) return;
    lines.begin("midair_messages_total", "Messages for the operator by code.", "counter");
    for (const auto& [code, total] : view.messages)
    {
        lines.sample("midair_messages_total",
                     fmt::format("code=\"{}\",severity=\"{}\"",
                                 labelValue(code),
                                 kSeverityNames.at(total.severity)),
                     static_cast<double>(total.total));
    }
}

} // namespace

std::string statusJson(const MonitorState& state)
{
    const MonitorView& view = state.view;
    const auto ageOf = [&](double time_s)
    { return view.isRead ? Json(state.now_s - time_s) : Json(); };
    const bool isStanding = state.isStanding();
    Json json = {{"name", state.name},
                 {"reading", {{"isOld", state.isOld()}, {"age_s", ageOf(view.read_s)}}},
                 {"frames",
                  {{"count", view.reading.statistics.frames},
                   {"isStanding", isStanding},
                   {"age_s", ageOf(view.frame_s)},
                   {"perSecond", isStanding ? 0.0 : view.framesPerSecond}}}};
    for (const char* said :
         {"array", "error", "latency_ms", "exposure", "fields", "counters", "messages"})
        json[said] = nullptr;
    if (!state.isOld()) addReading(json, state);
    json["mute"] = nullptr;
    if (!view.mutedBy.empty())
        json["mute"] = {{"by", view.mutedBy}, {"age_s", state.now_s - view.muted_s}};
    json["events"] = Json::array();
    for (const MonitorEvent& event : view.events)
        json["events"].push_back(
            {{"age_s", state.now_s - event.time_s}, {"text", event.text}, {"count", event.count}});
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
    const ArrayState array = state.view.reading.statistics.state;
    if (array == ArrayState::CLOSED || array == ArrayState::LOST || array == ArrayState::FAULT)
        return fmt::format("the array is {}", midair::bridge::stateName(array));
    return {};
}

std::string metricsText(const MonitorState& state)
{
    MetricLines lines;
    addPage(lines, state);
    if (state.isOld()) return lines.take();
    addArray(lines, state);
    addField(lines, state.view.reading.statistics);
    addExposure(lines, state.view.reading.statistics.exposure);
    addCounts(lines, state.view);
    return lines.take();
}

std::string labelValue(std::string text)
{
    // Of JSON's escapes a label has those of quotes, backslashes and line ends alone.
    std::replace_if(
        text.begin(),
        text.end(),
        [](char c) { return static_cast<unsigned char>(c) < 0x20 && c != '\n'; },
        ' ');
    const std::string quoted = dumped(text);
    return quoted.substr(1, quoted.size() - 2);
}

} // namespace midair::samples
