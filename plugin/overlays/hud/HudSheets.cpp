#include "plugin/overlays/hud/HudSheets.h"

#include "engine-bridge/display/Coincidence.h"
#include "haptics/base/settings/Setting.h"
#include "plugin/engine/SceneAccess.h"

#include <osgMidair/ExposureOverlay>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

using midair::bridge::HologramResult;
using pixels::TextPanel;

const osg::Vec4 kBright(0.96F, 0.97F, 0.99F, 1.0F);
const osg::Vec4 kDim(0.72F, 0.76F, 0.82F, 1.0F);
const osg::Vec4 kWarning(1.0F, 0.80F, 0.35F, 1.0F);
// Dark enough to read dim letters on it over white.
const osg::Vec4 kPanel(0.085F, 0.10F, 0.125F, 0.86F);
const osg::Vec4 kSilence(0.62F, 0.06F, 0.08F, 0.90F);
const osg::Vec4 kLess(0.50F, 0.33F, 0.02F, 0.90F);
constexpr float kPad = 8.0F;
constexpr float kLeading = 2.0F;
constexpr float kCourseWidth = 226.0F;
constexpr float kCourseHeight = 112.0F;
constexpr float kScaleWidth = 94.0F;

/// Splits \a text between words into at most \a most lines of at most \a width; the rest is cut
/// off.
std::vector<std::string> wrapped(const std::string& text, float size, float width, int most)
{
    std::vector<std::string> lines;
    std::string rest = text;
    while (static_cast<int>(lines.size()) < most - 1 && TextPanel::width(rest, size) > width)
    {
        std::size_t end = std::string::npos;
        for (std::size_t at = rest.find(' '); at != std::string::npos; at = rest.find(' ', at + 1))
        {
            if (TextPanel::width(rest.substr(0, at), size) > width) break;
            end = at;
        }
        if (end == std::string::npos) break; // the word is too long
        lines.push_back(rest.substr(0, end));
        rest = rest.substr(end + 1);
    }
    lines.push_back(TextPanel::fitted(rest, size, width));
    return lines;
}

/// Draws the pressure on the skin over time, with its axes.
void drawSkin(TextPanel& sheet, const osg::Vec2& lowerLeft, const SkinCurve& skin)
{
    constexpr float kText = 11.0F;
    const osg::Vec4 axis(0.45F, 0.48F, 0.54F, 0.8F);
    const osg::Vec2 upperRight = lowerLeft + osg::Vec2(kCourseWidth, kCourseHeight);
    sheet.strokes().rectangle(lowerLeft, upperRight, kPanel);
    sheet.text("radiation pressure on the skin, Pa",
               {lowerLeft.x() + kPad, upperRight.y() - kPad - kText},
               12.0F,
               kDim);
    const osg::Vec2 origin = lowerLeft + osg::Vec2(40.0F, 30.0F);
    const osg::Vec2 size(kCourseWidth - 40.0F - 2.0F * kPad, kCourseHeight - 64.0F);
    // From 0 to the next round number above the largest value.
    const double most = std::max(1e-9, skin.pressure_Pa.maxCoeff());
    const std::vector<double> ticks = pixels::ticks(0.0, 1.25 * most, 4);
    const double top = std::max(most, ticks.empty() ? most : ticks.back());
    for (const double tick : ticks)
    {
        const float y = origin.y() + size.y() * static_cast<float>(tick / top);
        sheet.strokes().line({origin.x(), y}, {origin.x() + size.x(), y}, 1.0F, axis);
        sheet.text(
            pixels::number(tick), {origin.x() - 4.0F, y - 4.0F}, kText, kDim, TextPanel::RIGHT);
    }
    const auto at = [&](Eigen::Index i)
    {
        return origin + osg::Vec2(size.x() * static_cast<float>(i) /
                                      static_cast<float>(skin.pressure_Pa.size() - 1),
                                  size.y() * static_cast<float>(skin.pressure_Pa[i] / top));
    };
    for (Eigen::Index i = 1; i < skin.pressure_Pa.size(); ++i)
        sheet.strokes().line(at(i - 1), at(i), 1.5F, {1.0F, 0.62F, 0.22F, 1.0F});
    const float below = lowerLeft.y() + kPad;
    sheet.text("-" + pixels::number(std::round(1e3 * skin.duration_s)) + " ms",
               {origin.x(), below},
               kText,
               kDim);
    sheet.text("time", {origin.x() + 0.5F * size.x(), below}, kText, kDim, TextPanel::CENTER);
    sheet.text("now", {origin.x() + size.x(), below}, kText, kDim, TextPanel::RIGHT);
}

/// Labels at the ends of a scale and its middle.
pixels::Labels levelLabels(double low, double high)
{
    pixels::Labels labels;
    for (const double share : {0.0, 0.5, 1.0})
        labels.emplace_back(share, pixels::number(low + share * (high - low)));
    return labels;
}

/// Returns the text without its node's path at the front: the cause comes first because the end may
/// be cut off.
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

/// Returns the newest active message of \a severity, its cause first; empty: none.
std::string newest(const HapticStatistics& statistics, HapticMessage::Severity severity)
{
    const auto found = std::find_if(statistics.told.rbegin(),
                                    statistics.told.rend(),
                                    [&](const HapticMessage& message)
                                    { return message.isActive && message.severity == severity; });
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
        return "no haptic object in sight";
    if (now.outOfReach > 0 && now.hands == 0) return "no hand is near";
    const std::string warning = newest(now, HapticMessage::WARNING);
    return warning.empty() ? "there is nothing to play" : warning;
}

/// Returns true if everything is rendered by contacts and nobody touches: that is no problem.
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
        {Row::POINTS, "points skipped"}, {Row::FIELDS, "fields skipped"}, {Row::MESHES, "meshes"}};
    for (const auto& [line, name] : kLines)
    {
        std::vector<std::string> texts;
        for (const Row& row : midair::bridge::kHologramCounters)
            if (const std::uint64_t count = counters.*row.value; row.line == line && count > 0)
                texts.push_back(pixels::number(static_cast<double>(count)) + " " + row.word);
        if (!texts.empty()) rows.emplace_back(name, fmt::format("{}", fmt::join(texts, ", ")));
    }
}

/// Contacts, "1, 3 foci", and the share of whole objects besides.
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

/// The cap that binds, "800 Pa" or "110 dB at ears"; both if it is unknown.
std::string capsOf(const HapticStatistics& now)
{
    const auto binds = [&now](const char* code)
    {
        return std::any_of(now.told.begin(),
                           now.told.end(),
                           [code](const HapticMessage& one)
                           { return one.isActive && one.code == code; });
    };
    const bool byPressure = binds("cap.pressure"), byEars = binds("cap.ears");
    std::string caps;
    if (now.maxPressure_Pa > 0.0 && (byPressure || !byEars))
        caps = fmt::format("{:g} Pa", now.maxPressure_Pa);
    if (now.exposure.limit_dB > 0.0 && (byEars || !byPressure))
        caps +=
            fmt::format("{}{:g} dB at ears", caps.empty() ? "" : " and ", now.exposure.limit_dB);
    return caps;
}

/// True: the field has no points, as of contacts that nobody touches.
bool isOfNothing(const HologramResult& result)
{
    return result.report().points == 0 && !(result.report().level_Pa > 0.0);
}

/// The pressure at the points, "none" of a field without any, "0 of" it while it isn't played, or a
/// text if no level of the array is low enough.
std::string pressureOf(const HologramResult& result, const ArrayNews& news)
{
    const midair::haptics::SolveReport& report = result.report();
    if (result.isSilenced()) return midair::haptics::stopReasonName(report.stop);
    if (isOfNothing(result)) return "none";
    const bool plays = !news.isMuted && news.statistics.state == ArrayState::PLAYING;
    return (plays ? "" : "0 of ") + pixels::number(std::round(report.level_Pa)) + " Pa (peak)";
}

/// The error at the points, or for an evened field, which is no longer for its points, the
/// radiation pressure on the surface.
HudRows::value_type errorOf(const HologramResult& result)
{
    const midair::haptics::SolveReport& report = result.report();
    if (result.sequence.evened && result.sequence.isHeld())
        return {"surface",
                fmt::format("{:.0f} Pa (mean), +- {:.0f} %",
                            report.surface.mean_Pa,
                            100.0 * report.surface.coefficientOfVariation)};
    if (isOfNothing(result)) return {"error rms", "none"};
    return {"error rms",
            fmt::format("{:.2f} % (max {:.2f} %)", 100.0 * report.rms, 100.0 * report.max)};
}

/// What a fingertip feels at the strongest place of the field.
std::string feelingOf(const HologramResult& result, const ArrayNews& news)
{
    if (news.isMuted || news.statistics.state != ArrayState::PLAYING) return "nothing";
    return midair::haptics::forceText(result.fingertip.force_N) + ", " + result.fingertip.feeling();
}

} // namespace

ArrayNews newsOf(const HologramResult& result)
{
    ArrayNews news;
    midair::base::assignPart<midair::bridge::HologramCounters>(news.statistics, result.counters);
    midair::base::assignPart<midair::haptics::FieldFigures>(news.statistics, result.report());
    news.statistics.points = result.points.size();
    news.statistics.maxPressure_Pa = result.maxPressure_Pa;
    news.statistics.fingertipForce_N = result.fingertip.force_N;
    news.statistics.feeling = result.fingertip.feeling();
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
    if (news.isMuted || now.state == ArrayState::MUTED) return {"MUTED", "press F8 to play again"};
    switch (now.state)
    {
    case ArrayState::LOST:
        return {"LOST", now.device};
    case ArrayState::FAULT:
        return {"FAULT", now.device};
    case ArrayState::CLOSED:
    {
        // Between opening and the first field there is no problem.
        const std::string fault = newest(now, HapticMessage::FAULT);
        if (news.isEnabled && fault.empty()) return {};
        return {"SILENT", news.isEnabled ? fault : whySilent(news, nullptr)};
    }
    case ArrayState::SILENT:
        if (isUntouched(result) && newest(now, HapticMessage::FAULT).empty()) return {};
        return {"SILENT", whySilent(news, result)};
    case ArrayState::PLAYING:
        if (now.capFactor >= 1.0) return {};
        return {
            "CAPPED",
            fmt::format("limited to {}: {:.0f} % of the drive", capsOf(now), 100.0 * now.capFactor),
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
    rows.emplace_back("fingertip", feelingOf(result, news));
    rows.push_back(errorOf(result));
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
    if (!news.statistics.coincidence.empty())
        rows.emplace_back("visual offset",
                          midair::bridge::textOf(news.statistics.coincidence.front()));
    if (news.statistics.exposure.places > 0)
        rows.emplace_back("at ears",
                          fmt::format("{:.0f} dB (eq {:.0f}, max {:.0f})",
                                      news.statistics.exposure.level_dB,
                                      news.statistics.exposure.eq_dB,
                                      news.statistics.exposure.max_dB));
    if (result.monitored && result.monitored->certificate.points > 0)
        rows.emplace_back(
            "gap to best",
            fmt::format("at most {:.1f} %", 100.0 * result.monitored->certificate.gapOfPhases()));
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
    // Events stay listed; conditions that have ended don't.
    std::vector<const HapticMessage*> order;
    for (auto message = news.statistics.told.rbegin(); message != news.statistics.told.rend();
         ++message)
        if (message->until_s == 0.0) order.push_back(&*message);
    std::stable_sort(order.begin(),
                     order.end(),
                     [](const HapticMessage* a, const HapticMessage* b) {
                         return std::make_pair(a->isActive, a->severity) >
                                std::make_pair(b->isActive, b->severity);
                     });
    std::vector<std::string> texts;
    for (const HapticMessage* message : order)
    {
        std::string text = causeFirst(*message);
        const bool isSaid = text == alarm.reason || message->text == alarm.reason ||
                            message->code == "device.muted" ||
                            (alarm.word == "CAPPED" &&
                             (message->code == "cap.pressure" || message->code == "cap.ears"));
        if (!isSaid) texts.push_back(std::move(text));
    }
    return texts;
}

const std::array<HudLayout, 3> kHudLayouts = {
    {{300.0F, 110.0F, 12.0F, 4, 2, 212.0F, 66.0F, false, false, 1, 56.0F, 280.0F, 24.0F},
     {620.0F, 220.0F, 13.0F, 8, 3, 290.0F, 104.0F, true, false, 3, 64.0F, 520.0F, 34.0F},
     {940.0F, 420.0F, 13.0F, 20, 4, 302.0F, 108.0F, true, true, 4, 110.0F, 640.0F, 44.0F}}};

void HudSheets::drawFigures(const std::string& title,
                            const HudRows& rows,
                            const pixels::Sparkline& error,
                            const pixels::Sparkline& latency,
                            const SkinCurve& skin)
{
    TextPanel& sheet = *figures.panel;
    sheet.clear();
    const float row = layout.text + kLeading;
    std::vector<std::vector<std::string>> values;
    std::size_t lines = 0;
    for (const auto& each : rows)
    {
        if (static_cast<int>(values.size()) == layout.rows) break;
        const float room = layout.panel - layout.names - 2.0F * kPad;
        values.push_back(wrapped(each.second, layout.text, room, layout.rows > 4 ? 2 : 1));
        lines += values.back().size();
    }
    const float titled = layout.isTitled ? layout.text + 8.0F : 0.0F;
    float y = 2.0F * kPad + titled + row * static_cast<float>(lines) - kLeading;
    figures.size.set(layout.panel, y);
    sheet.strokes().rectangle({0.0F, 0.0F}, figures.size, kPanel);
    y -= kPad;
    if (layout.isTitled)
    {
        const float size = layout.text + 1.0F;
        sheet.text(TextPanel::fitted(title, size, layout.panel - 2.0F * kPad),
                   {kPad, y - size},
                   size,
                   kBright);
        y -= titled;
    }
    for (std::size_t i = 0; i < values.size(); ++i)
    {
        sheet.text(rows[i].first, {kPad, y - row + 2.0F * kLeading}, layout.text, kDim);
        for (const std::string& line : values[i])
        {
            y -= row;
            sheet.text(line, {kPad + layout.names, y + 2.0F * kLeading}, layout.text, kBright);
        }
    }
    if (layout.hasCourses)
    {
        const float x = layout.panel + kPad;
        sheet.strokes().rectangle({x, 0.0F}, {x + kCourseWidth, kCourseHeight}, kPanel);
        error.draw(sheet, {x + kPad, 64.0F}, {132.0F, 28.0F});
        latency.draw(sheet, {x + kPad, 8.0F}, {132.0F, 28.0F});
        figures.size.x() = x + kCourseWidth;
        if (skin.pressure_Pa.size() > 1)
        {
            drawSkin(sheet, {x, kCourseHeight + kPad}, skin);
            figures.size.y() = std::max(figures.size.y(), 2.0F * kCourseHeight + kPad);
        }
    }
    sheet.finish();
}

void HudSheets::drawMessages(const std::vector<std::string>& texts)
{
    TextPanel& sheet = *messages.panel;
    sheet.clear();
    std::vector<std::pair<std::string, bool>> lines; // and whether a message begins
    const auto shown = std::min(texts.size(), static_cast<std::size_t>(layout.messages));
    for (std::size_t i = 0; i < shown; ++i)
    {
        const auto parts = wrapped(texts[i], layout.text, layout.line - 10.0F, 2);
        for (const std::string& part : parts)
            lines.emplace_back(part, &part == &parts.front());
    }
    if (texts.size() > shown)
        lines.emplace_back("and " + std::to_string(texts.size() - shown) + " more in the log",
                           false);
    messages.size.set(0.0F, 0.0F);
    if (!lines.empty())
    {
        const float row = layout.text + kLeading;
        float width = 0.0F;
        for (const auto& line : lines)
            width = std::max(width, TextPanel::width(line.first, layout.text));
        float y = kPad + row * static_cast<float>(lines.size());
        messages.size.set(width + 2.0F * kPad + 10.0F, y);
        sheet.strokes().rectangle({0.0F, 0.0F}, messages.size, kPanel);
        y -= 0.5F * kPad;
        for (const auto& [line, begins] : lines)
        {
            y -= row;
            if (begins) sheet.strokes().disc({kPad + 2.0F, y + 0.6F * layout.text}, 2.0F, kWarning);
            sheet.text(line,
                       {kPad + 10.0F, y + 2.0F * kLeading},
                       layout.text,
                       begins ? kWarning : kBright);
        }
    }
    sheet.finish();
}

void HudSheets::drawScales(float field_Pa, float volume_Pa, bool points, bool array, bool around)
{
    TextPanel& sheet = *scales.panel;
    sheet.clear();
    std::vector<pixels::Scale> all;
    const auto add = [&](const ColorMap& map, const char* heading) -> pixels::Scale&
    {
        pixels::Scale scale;
        scale.map = &map;
        scale.heading = heading;
        scale.size = {14.0F, layout.scaleHeight};
        all.push_back(scale);
        return all.back();
    };
    const int ticks = layout.scaleHeight < 70.0F ? 3 : 5;
    if (around)
        add(ColorMap::pressure(), "around, dB").labels =
            levelLabels(ExposureOverlay::kLow_dB, ExposureOverlay::kHigh_dB);
    if (field_Pa > 0.0F)
        add(ColorMap::pressure(), "|p| (peak), Pa").labels = pixels::labelsTo(field_Pa, ticks);
    if (volume_Pa > 0.0F)
        add(ColorMap::radiation(), "radiation, Pa").labels = pixels::labelsTo(volume_Pa, ticks);
    if (points)
        add(ColorMap::diverging(), "got / wanted").labels = {
            {0.0, "50 %"}, {0.5, "100 %"}, {1.0, "200 %"}};
    if (array)
        add(ColorMap::phase(), "drive phase").labels = {{0.0, "0"}, {0.5, "180°"}, {1.0, "360°"}};
    all.resize(std::min(all.size(), static_cast<std::size_t>(layout.scales)));
    scales.size.set(0.0F, 0.0F);
    if (!all.empty())
    {
        scales.size.set(kScaleWidth * static_cast<float>(all.size()) + kPad,
                        layout.scaleHeight + 40.0F);
        sheet.strokes().rectangle({0.0F, 0.0F}, scales.size, kPanel);
        float x = kPad;
        for (pixels::Scale& scale : all)
        {
            scale.lowerLeft = {x, 12.0F};
            scale.draw(sheet, 12.0F, kBright);
            x += kScaleWidth;
        }
    }
    sheet.finish();
}

void HudSheets::drawAlarm(const HudAlarm& given)
{
    TextPanel& sheet = *alarm.panel;
    sheet.clear();
    alarm.size.set(0.0F, 0.0F);
    if (!given.word.empty())
    {
        const float row = layout.text + kLeading;
        // If something is played, the sign stands beside it: as narrow as the figures.
        const float word = given.isSilence ? layout.word : 0.6F * layout.word;
        const float line = given.isSilence ? layout.line : layout.panel - 4.0F * kPad;
        std::vector<std::string> lines;
        if (!given.reason.empty())
            lines = wrapped(given.reason, layout.text, line, given.isSilence ? 2 : 4);
        float width = TextPanel::width(given.word, word);
        for (const std::string& line : lines)
            width = std::max(width, TextPanel::width(line, layout.text));
        const float height = word + row * static_cast<float>(lines.size()) + 1.5F * kPad;
        alarm.size.set(width + 4.0F * kPad, height);
        sheet.strokes().rectangle({0.0F, 0.0F}, alarm.size, given.isSilence ? kSilence : kLess);
        const float middle = 0.5F * alarm.size.x();
        float y = height - 0.5F * kPad - 0.86F * word;
        sheet.text(given.word, {middle, y}, word, kBright, TextPanel::CENTER);
        y -= 0.5F * kPad;
        for (const std::string& line : lines)
            sheet.text(line, {middle, y -= row}, layout.text, kBright, TextPanel::CENTER);
    }
    sheet.finish();
}

void HudSheets::drawKeys(const std::vector<HudKey>& all)
{
    TextPanel& sheet = *keys.panel;
    sheet.clear();
    keys.size.set(0.0F, 0.0F);
    constexpr float kGap = 14.0F;
    const float row = layout.text + 2.0F * kLeading;
    std::vector<osg::Vec2> places; // rows from 0 downwards
    osg::Vec2 pen;
    float widest = 0.0F;
    for (const HudKey& key : all)
    {
        const float width = TextPanel::width(key.text, layout.text);
        if (pen.x() > 0.0F && pen.x() + width > layout.line) pen.set(0.0F, pen.y() - row);
        places.push_back(pen);
        widest = std::max(widest, pen.x() + width);
        pen.x() += width + kGap;
    }
    if (!all.empty())
    {
        const float height = row - pen.y() + kPad;
        keys.size.set(widest + 2.0F * kPad, height);
        sheet.strokes().rectangle({0.0F, 0.0F}, keys.size, kPanel);
        const osg::Vec2 first(kPad, height - 0.5F * kPad - row + 2.0F * kLeading);
        for (std::size_t i = 0; i < all.size(); ++i)
            sheet.text(all[i].text, first + places[i], layout.text, all[i].isOn ? kBright : kDim);
    }
    sheet.finish();
}

} // namespace osgMidair
