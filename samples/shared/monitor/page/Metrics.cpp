#include "samples/shared/monitor/page/Metrics.h"

#include <array>
#include <cctype>
#include <cmath>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace midair::samples
{

namespace
{

using osgMidair::ArrayState;
using osgMidair::HapticStatistics;

/// Writes metrics, each with its two lines of comment before it.
class MetricLines
{
public:
    void gauge(const std::string& name, std::string_view help, double value)
    {
        begin(name, help, "gauge");
        sample(name, {}, value);
    }
    /// \a name without "_total".
    void counter(const std::string& name, std::string_view help, std::uint64_t value)
    {
        begin(name + "_total", help, "counter");
        sample(name + "_total", {}, static_cast<double>(value));
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
    for (const auto& [status, count] : state.page.answers)
        lines.sample("midair_page_answers_total",
                     fmt::format("code=\"{}\"", status),
                     static_cast<double>(count));
    lines.counter("midair_page_pictures", "Pictures taken for the page.", state.picture.count);
    lines.begin("midair_page_picture_readback_seconds_total",
                "Time that the thread that draws has spent on pictures for the page.",
                "counter");
    lines.sample("midair_page_picture_readback_seconds_total", {}, 1e-3 * state.picture.sum_ms);
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
            lines.gauge(name, row.help, static_cast<double>(s.fields.*row.value));
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
    {
        double factor = 1.0;
        const std::string name = metricName(figure, factor);
        lines.gauge(
            "midair_field_" + name,
            figure == "rms"
                ? "Relative rms error of the pressures at the control points; while the array "
                  "doesn't play, of a field that nobody feels."
                : fmt::format("Figure {} of the newest field.", figure),
            value * factor);
    }
}

void addExposure(MetricLines& lines, const midair::haptics::ExposureFigures& exposure)
{
    if (exposure.places == 0) return;
    for (const midair::haptics::ExposureRow& row : midair::haptics::kExposureFigures)
    {
        double factor = 1.0;
        const std::string name = metricName(row.name, factor);
        const double value = std::visit(
            [&](auto member) { return static_cast<double>(exposure.*member); }, row.value);
        lines.gauge("midair_exposure_" + name,
                    fmt::format("Figure {} of the level at ears, computed, with {:g} dB for a "
                                "head; not a safety certificate.",
                                row.name,
                                midair::haptics::kHeadMargin_dB),
                    value * factor);
    }
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
    std::string stem = figure;
    std::string_view unit;
    for (const Unit& each : kUnits)
        if (stem.size() > each.ending.size() &&
            stem.compare(stem.size() - each.ending.size(), each.ending.size(), each.ending) == 0)
        {
            stem.resize(stem.size() - each.ending.size());
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

std::string labelValue(const std::string& text)
{
    // JSON's writer replaces what is no UTF-8; the exposition format knows three escapes alone.
    const nlohmann::json any = text;
    const std::string quoted = any.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    const std::string valid = nlohmann::json::parse(quoted).get<std::string>();
    std::string value;
    for (const char c : valid)
        switch (c)
        {
        case '\\':
            value += "\\\\";
            break;
        case '"':
            value += "\\\"";
            break;
        case '\n':
            value += "\\n";
            break;
        default:
            value += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
        }
    return value;
}

} // namespace midair::samples
