#include "samples/shared/monitor/page/MonitorTexts.h"

#include "haptics/probe/Feeling.h"

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

/// Indexed by HapticMessage::Severity.
constexpr std::array kSeverityNames = {"notice", "warning", "fault"};

/// Returns JSON text; invalid UTF-8 is replaced.
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

/// Returns the errors of the newest field, or null before the first.
Json errorJson(const HapticStatistics& s)
{
    if (s.figures.empty()) return nullptr;
    Json json = {{"rms", s.rms},
                 {"max", s.max},
                 {"level_Pa", s.level_Pa},
                 {"fingertip", midair::haptics::forceText(s.fingertipForce_N)},
                 {"feeling", s.feeling},
                 {"capFactor", s.capFactor},
                 {"leftOut", s.leftOut},
                 {"stop", s.stop},
                 {"fieldsInTurn", s.fieldsInTurn},
                 {"evened", s.evened},
                 {"updatesPerSecond", s.updatesPerSecond}};
    for (const auto& [name, value] : s.figures)
        if (!json.contains(name)) json[name] = value;
    return json;
}

/// Returns the Prometheus name of a figure: "meanPhaseStep_rad" becomes "mean_phase_step_radians".
/// \a factor is set to the conversion of its values: milliseconds become seconds.
std::string metricName(const std::string& figure, double& factor)
{
    struct Unit
    {
        std::string_view ending;
        std::string_view name;
        double factor;
    };
    constexpr std::array<Unit, 9> kUnits = {{{"_Pa", "_pascals", 1.0},
                                             {"_N", "_newtons", 1.0},
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

/// Calls \a take with the name and the value of each exposure figure.
template<typename Take>
void eachExposure(const midair::haptics::ExposureFigures& exposure, const Take& take)
{
    for (const midair::haptics::ExposureRow& row : midair::haptics::kExposureFigures)
        std::visit([&](auto member) { take(row.name, exposure.*member); }, row.value);
}

/// Returns the distance between seen and felt places of objects, or "unknown" with the reason,
/// never 0, if it isn't known.
Json coincidenceJson(const HapticStatistics& s)
{
    using midair::bridge::CoincidencePart;
    const auto partJson = [](const CoincidencePart& part) -> Json
    {
        if (part.state == CoincidencePart::NONE) return "none";
        if (part.state == CoincidencePart::UNKNOWN) return "unknown";
        return {{"median_mm", part.median_mm}, {"p95_mm", part.most_mm}};
    };
    Json json = Json::array();
    for (const midair::bridge::CoincidenceFigures& one : s.coincidence)
    {
        Json object = {{"path", one.object},
                       {"total", partJson(one.total)},
                       {"largest", one.largest},
                       {"unknown", one.unknown}};
        for (const midair::bridge::CoincidenceRow& row : midair::bridge::kCoincidenceParts)
            object["parts"][row.name] = partJson(one.*row.part);
        json.push_back(std::move(object));
    }
    return json;
}

/// Adds the newest reading.
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
    json["coincidence"] = coincidenceJson(s);
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

/// Formats metrics, each with its HELP and TYPE lines.
class MetricLines
{
public:
    template<typename Number>
    void gauge(const std::string& name, std::string_view help, Number value)
    {
        begin(name, help, "gauge");
        sample(name, {}, static_cast<double>(value));
    }
    /// \a name has no "_total".
    template<typename Number>
    void counter(const std::string& name, std::string_view help, Number value)
    {
        begin(name + "_total", help, "counter");
        sample(name + "_total", {}, static_cast<double>(value));
    }
    /// A gauge named after a figure, in Prometheus' units.
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
                "1: the program answers; 0: it hangs and its state is unknown.",
                state.isOld() ? 0.0 : 1.0);
    if (state.view.isRead)
    {
        lines.gauge("midair_reading_age_seconds",
                    "Age of the newest reading.",
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
                  "Time that the drawing thread has spent on pictures for the page.",
                  1e-3 * state.picture.sum_ms);
}

/// Returns the device without the changing part: counters and errors.
std::string deviceOf(const HapticStatistics& s)
{
    if (s.state == ArrayState::CLOSED || s.state == ArrayState::OPENING) return "not open";
    return s.device.substr(0, s.device.find_first_of(",;"));
}

void addArray(MetricLines& lines, const MonitorState& state)
{
    const HapticStatistics& s = state.view.reading.statistics;
    lines.begin("midair_array_state", "1 for the array's current state, 0 for others.", "gauge");
    for (int i = 0; i <= static_cast<int>(ArrayState::FAULT); ++i)
    {
        const auto each = static_cast<ArrayState>(i);
        lines.sample("midair_array_state",
                     fmt::format("state=\"{}\"", midair::bridge::stateName(each)),
                     each == s.state ? 1.0 : 0.0);
    }
    lines.begin(
        "midair_array_info", "Always 1; its labels name the array and the device.", "gauge");
    lines.sample("midair_array_info",
                 fmt::format("name=\"{}\",array=\"{}\",device=\"{}\"",
                             labelValue(state.name),
                             labelValue(state.view.reading.array),
                             labelValue(deviceOf(s))),
                 1.0);
    lines.gauge("midair_muted", "1: mute requested.", state.view.reading.isMuted ? 1.0 : 0.0);
    lines.gauge("midair_air_temperature_celsius",
                "Air temperature used to compute fields.",
                s.temperature_C);
    lines.gauge("midair_objects", "Current number of haptic objects.", s.objects);
    lines.gauge("midair_hands", "Current number of tracked hands.", s.hands);
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
    lines.gauge("midair_field_evened",
                "1: the field rests and is evened out over its surfaces, so that the errors at its "
                "points are large.",
                s.evened ? 1.0 : 0.0);
    for (const auto& [figure, value] : s.figures)
        lines.figure("midair_field_",
                     figure,
                     figure == "rms" ? "Relative rms error of the pressures at the control points; "
                                       "also computed while nothing plays."
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
    for (const char* said : {"array",
                             "error",
                             "latency_ms",
                             "exposure",
                             "coincidence",
                             "fields",
                             "counters",
                             "messages"})
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
    if (!state.view.isRead) return "no data from the program yet";
    if (state.isOld())
        return fmt::format("no data for {:.1f} s: the program hangs",
                           state.now_s - state.view.read_s);
    if (state.isStanding())
        return fmt::format("no frame for {:.1f} s: the frame loop has stopped",
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
    // Labels allow only JSON's escapes for quotes, backslashes and line feeds.
    std::replace_if(
        text.begin(),
        text.end(),
        [](char c) { return static_cast<unsigned char>(c) < 0x20 && c != '\n'; },
        ' ');
    const std::string quoted = dumped(text);
    return quoted.substr(1, quoted.size() - 2);
}

} // namespace midair::samples
