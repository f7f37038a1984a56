#include "plugin/overlays/hud/HudContent.h"

#include "haptics/base/settings/Setting.h"
#include "plugin/engine/PublicMessage.h"
#include "plugin/overlays/drawing/PixelDrawing.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <fmt/format.h>

namespace osgMidair
{

using midair::bridge::HologramResult;

namespace
{

/// Returns the text without its node's path at the front: the cause comes first, as the end may be
/// cut off.
std::string causeFirst(const HapticMessage& message)
{
    const std::string path = message.path + ": ";
    if (message.path.empty() || message.text.compare(0, path.size(), path) != 0)
        return message.text;
    std::string node = message.path.substr(message.path.rfind('/') + 1);
    const std::size_t name = node.find('\'');
    if (name != std::string::npos) node = node.substr(name);
    return message.text.substr(path.size()) + " (" + node + ")";
}

/// Returns the newest message of \a severity, its cause first; empty: none.
std::string newest(const HapticStatistics& statistics, HapticMessage::Severity severity)
{
    const auto found =
        std::find_if(statistics.told.rbegin(),
                     statistics.told.rend(),
                     [&](const HapticMessage& message) { return message.severity == severity; });
    return found == statistics.told.rend() ? std::string() : causeFirst(*found);
}

std::string whySilent(const ArrayNews& news, const HologramResult* result)
{
    const HapticStatistics& now = news.statistics;
    if (!news.isEnabled)
    {
        const std::string fault = newest(now, HapticMessage::FAULT);
        return fault.empty() ? "the scene is disabled (Enabled)" : fault;
    }
    if (result && !result->report().message.empty()) return result->report().message;
    if (now.points > 0) return newest(now, HapticMessage::FAULT);
    if (result && result->points.size() == 0 && now.objects == 0)
        return "no haptic object is to be seen here";
    if (now.outOfReach > 0 && now.hands == 0) return "no hand is near";
    const std::string warning = newest(now, HapticMessage::WARNING);
    return warning.empty() ? "there is nothing to play" : warning;
}

/// Returns true where all is felt by contacts and nobody touches: nothing is wrong then.
bool isUntouched(const HologramResult* result)
{
    return result && result->touched && result->points.size() == 0 &&
           result->report().message.empty();
}

/// Adds rows with the counters, without counts of 0.
void addSpared(HudRows& rows, const midair::bridge::HologramCounters& counters)
{
    using Row = midair::bridge::CounterRow;
    constexpr std::pair<Row::Line, const char*> kLines[] = {
        {Row::POINTS, "points spared"}, {Row::FIELDS, "fields spared"}, {Row::MESHES, "meshes"}};
    for (const auto& [line, name] : kLines)
    {
        std::vector<std::string> texts;
        for (const Row& row : midair::bridge::kHologramCounters)
            if (const std::uint64_t count = counters.*row.value; row.line == line && count > 0)
                texts.push_back(pixels::number(static_cast<double>(count)) + " " + row.word);
        if (!texts.empty()) rows.emplace_back(name, fmt::format("{}", fmt::join(texts, ", ")));
    }
}

/// What is played where hands touch: "1, 3 foci", and how much of whole objects is besides.
std::string contactsOf(const midair::bridge::ContactScene& scene)
{
    std::size_t contacts = 0;
    Eigen::Index foci = 0;
    for (const midair::bridge::ContactView& contact : scene.contacts)
    {
        if (contact.foci.cols() == 0) continue;
        ++contacts;
        foci += contact.foci.cols();
    }
    const std::string whole =
        scene.whole > 0.0 ? fmt::format(", {:.0f} % whole", 100.0 * scene.whole) : "";
    return contacts == 0
               ? "none" + whole
               : fmt::format("{}, {} {}{}", contacts, foci, foci == 1 ? "focus" : "foci", whole);
}

/// The caps that are set: "800 Pa", "110 dB at ears", or both.
std::string capsOf(const HapticStatistics& now)
{
    std::string caps;
    if (now.maxPressure_Pa > 0.0) caps = fmt::format("{:g} Pa", now.maxPressure_Pa);
    if (now.exposure.limit_dB > 0.0)
        caps +=
            fmt::format("{}{:g} dB at ears", caps.empty() ? "" : " and ", now.exposure.limit_dB);
    return caps;
}

/// The pressure at the points, 0 of it while it isn't played, or that no level of the array is low
/// enough for any.
std::string pressureOf(const HologramResult& result, const ArrayNews& news)
{
    const midair::haptics::SolveReport& report = result.report();
    if (result.isSilenced()) return midair::haptics::stopReasonName(report.stop);
    const bool plays = !news.isMuted && news.statistics.state == ArrayState::PLAYING;
    return (plays ? "" : "0 of ") + pixels::number(std::round(report.level_Pa)) + " Pa (peak)";
}

} // namespace

ArrayNews newsOf(const HologramResult& result)
{
    ArrayNews news;
    midair::base::assignPart<midair::bridge::HologramCounters>(news.statistics, result.counters);
    midair::base::assignPart<midair::haptics::FieldFigures>(news.statistics, result.report());
    news.statistics.points = result.points.size();
    news.statistics.maxPressure_Pa = result.maxPressure_Pa;
    news.statistics.exposure = result.exposure;
    news.statistics.objects = static_cast<int>(result.origins.size());
    news.statistics.state = result.state;
    news.statistics.device = result.deviceStatus;
    for (const midair::base::Message& message : result.told)
        news.statistics.told.push_back(toPublic(message));
    return news;
}

HudAlarm alarmOf(const ArrayNews& news, const HologramResult* result)
{
    const HapticStatistics& now = news.statistics;
    if (news.isMuted || now.state == ArrayState::MUTED)
        return {"MUTED", "F8 lets the array play again"};
    switch (now.state)
    {
    case ArrayState::LOST:
        return {"LOST", now.device};
    case ArrayState::FAULT:
        return {"FAULT", now.device};
    case ArrayState::CLOSED:
    {
        // Between opening and the first field nothing is wrong.
        const std::string fault = newest(now, HapticMessage::FAULT);
        if (news.isEnabled && fault.empty()) return {};
        return {"SILENT", news.isEnabled ? fault : whySilent(news, nullptr)};
    }
    case ArrayState::SILENT:
        if (isUntouched(result) && newest(now, HapticMessage::FAULT).empty()) return {};
        return {"SILENT", whySilent(news, result)};
    case ArrayState::PLAYING:
        if (now.capFactor >= 1.0) return {};
        return {"CAPPED",
                fmt::format(
                    "held down to {}, {:.0f} % of the drive", capsOf(now), 100.0 * now.capFactor),
                false};
    default:
        return {};
    }
}

HudRows rowsOf(const HologramResult* field, const ArrayNews& news, const OverlayRates& rates)
{
    HudRows rows;
    rows.emplace_back("state",
                      news.isMuted ? "muted" : midair::bridge::stateName(news.statistics.state));
    if (!field) return rows;
    const HologramResult& result = *field;
    const midair::haptics::SolveReport& report = result.report();
    rows.emplace_back("pressure", pressureOf(result, news));
    rows.emplace_back(
        "error rms",
        fmt::format("{:.2f} % (max {:.2f} %)", 100.0 * report.rms, 100.0 * report.max));
    rows.emplace_back("latency", fmt::format("{:.1f} ms", result.latency_ms));
    rows.emplace_back("points",
                      fmt::format("{}, {} left out", report.points, result.skipped.cols()));
    if (result.touched) rows.emplace_back("contacts", contactsOf(*result.touched));
    rows.emplace_back("solve",
                      fmt::format("{:.2f} ms (matrix {:.2f})",
                                  report.matrix_ms + report.solve_ms,
                                  report.matrix_ms));
    rows.emplace_back("updates", fmt::format("{:.0f} / s", result.updatesPerSecond));
    rows.emplace_back("device", result.deviceStatus);
    rows.emplace_back("loudness E", fmt::format("{:.3f}", report.loudness));
    if (news.statistics.exposure.places > 0)
        rows.emplace_back("at ears",
                          fmt::format("{:.0f} dB (eq {:.0f}, max {:.0f})",
                                      news.statistics.exposure.level_dB,
                                      news.statistics.exposure.eq_dB,
                                      news.statistics.exposure.max_dB));
    if (result.monitored && result.monitored->certificate.points > 0)
        rows.emplace_back(
            "off the best",
            fmt::format("{:.1f} % at most", 100.0 * result.monitored->certificate.gapOfPhases()));
    if (report.surface.samples > 0)
        rows.emplace_back("surface cv",
                          fmt::format("{:.2f}", report.surface.coefficientOfVariation));
    addSpared(rows, result.counters);
    if (rates.slices > 0.0) rows.emplace_back("slice", fmt::format("{:.0f} / s", rates.slices));
    if (rates.volumes > 0.0) rows.emplace_back("volume", fmt::format("{:.0f} / s", rates.volumes));
    if (rates.frames > 0.0) rows.emplace_back("frames", fmt::format("{:.0f} / s", rates.frames));
    return rows;
}

std::vector<std::string> messagesOf(const ArrayNews& news, const HudAlarm& alarm)
{
    // While the array plays, what kept it from playing is over.
    const bool plays = news.statistics.state == ArrayState::PLAYING;
    const auto rank = [&](const HapticMessage& message)
    {
        if (message.severity == HapticMessage::FAULT) return plays ? 3 : 0;
        return message.severity == HapticMessage::WARNING ? 1 : 2;
    };
    std::vector<const HapticMessage*> order;
    for (auto message = news.statistics.told.rbegin(); message != news.statistics.told.rend();
         ++message)
        order.push_back(&*message);
    std::stable_sort(order.begin(),
                     order.end(),
                     [&](const HapticMessage* a, const HapticMessage* b)
                     { return rank(*a) < rank(*b); });
    std::vector<std::string> texts;
    for (const HapticMessage* message : order)
    {
        std::string text = causeFirst(*message);
        if (rank(*message) == 3) text.insert(0, "before: ");
        const bool isSaid = text == alarm.reason || message->text == alarm.reason ||
                            message->code == "device.muted" ||
                            (alarm.word == "CAPPED" &&
                             (message->code == "cap.pressure" || message->code == "cap.ears"));
        if (!isSaid) texts.push_back(std::move(text));
    }
    return texts;
}

} // namespace osgMidair
