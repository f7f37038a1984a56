#include "haptics/base/threads/SteadyClock.h"
#include "plugin/overlays/OverlayKinds.h"
#include "plugin/overlays/OverlayPart.h"
#include "plugin/overlays/drawing/DiscGeometry.h"
#include "plugin/overlays/drawing/TextPanel.h"

#include <osgMidair/Hud>

#include <osg/observer_ptr>
#include <osgGA/GUIEventAdapter>
#include <osgUtil/CullVisitor>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <vector>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

const OverlayNumber kScale = overlayNumber<Hud, &Hud::setScale, &Hud::getScale>(
    "figuresScale",
    "pixels per unit of the figures; 0: follows the viewport's height",
    {0.0, 20.0});
const OverlayNumber kInterval =
    overlayNumber<Hud, &Hud::setUpdateInterval, &Hud::getUpdateInterval>(
        "figuresInterval", "shortest time between two changes of the figures", {0.0, 60.0}, "s");
const OverlayRegistration kRegistration({5,
                                         "Figures",
                                         "figures",
                                         "the figures",
                                         osgGA::GUIEventAdapter::KEY_F6,
                                         0,
                                         makeOverlay<Hud>,
                                         {kScale, kInterval}});

const osg::Vec4 kBright(0.96F, 0.97F, 0.99F, 1.0F);
const osg::Vec4 kDim(0.68F, 0.72F, 0.78F, 1.0F);
const osg::Vec4 kWarning(1.0F, 0.80F, 0.35F, 1.0F);
const osg::Vec4 kPanel(0.085F, 0.10F, 0.125F, 0.72F);
constexpr float kTextSize = 13.0F;
constexpr float kRow = 15.0F;
constexpr float kPanelWidth = 302.0F;
constexpr float kNames = 108.0F; ///< width of the column of names
constexpr float kMargin = 10.0F;
constexpr float kMessageWidth = 520.0F;

/// Splits \a text between words into at most two lines of at most \a width; the rest is cut off.
std::vector<std::string> twoLines(const std::string& text, float width)
{
    if (pixels::TextPanel::width(text, kTextSize) <= width) return {text};
    std::size_t end = std::string::npos;
    for (std::size_t at = text.find(' '); at != std::string::npos; at = text.find(' ', at + 1))
        if (pixels::TextPanel::width(text.substr(0, at), kTextSize) <= width) end = at;
    if (end == std::string::npos) return {pixels::TextPanel::fitted(text, kTextSize, width)};
    return {text.substr(0, end), pixels::TextPanel::fitted(text.substr(end + 1), kTextSize, width)};
}

/// Draws the HUD: one sheet for each corner of the viewport in use.
class Panel
{
public:
    using Rows = std::vector<std::pair<std::string, std::string>>;

    Panel() :
        topLeft(new pixels::TextPanel),
        bottomLeft(new pixels::TextPanel),
        bottomRight(new pixels::TextPanel),
        error("error rms", "%"),
        latency("latency", "ms")
    {
        drawFigures({}, {});
        drawCourses();
        drawScales(0.0F, 0.0F);
    }

    /// Draws names and values, long values in two lines, and \a message below.
    void drawFigures(const Rows& rows, const std::string& message)
    {
        pixels::TextPanel& sheet = *topLeft;
        sheet.clear();
        std::vector<std::vector<std::string>> values;
        std::size_t lines = 0;
        for (const auto& row : rows)
        {
            values.push_back(twoLines(row.second, kPanelWidth - kNames - 16.0F));
            lines += values.back().size();
        }
        const float bottom = -kMargin - 34.0F - kRow * static_cast<float>(lines);
        sheet.strokes().rectangle({kMargin, bottom}, {kMargin + kPanelWidth, -kMargin}, kPanel);
        const float x = kMargin + 8.0F;
        sheet.text(pixels::TextPanel::fitted(title, kTextSize + 1.0F, kPanelWidth - 16.0F),
                   {x, -kMargin - 18.0F},
                   kTextSize + 1.0F,
                   kBright);
        float y = -kMargin - 24.0F;
        for (std::size_t i = 0; i < rows.size(); ++i)
        {
            sheet.text(rows[i].first, {x, y - kRow}, kTextSize, kDim);
            for (const std::string& line : values[i])
                sheet.text(line, {x + kNames, y -= kRow}, kTextSize, kBright);
        }
        if (!message.empty())
        {
            const std::string fits = pixels::TextPanel::fitted(message, kTextSize, kMessageWidth);
            const float width = pixels::TextPanel::width(fits, kTextSize) + 16.0F;
            sheet.strokes().rectangle(
                {kMargin, bottom - 26.0F}, {kMargin + width, bottom - 4.0F}, kPanel);
            sheet.text(fits, {x, bottom - 20.0F}, kTextSize, kWarning);
        }
        sheet.finish();
    }

    void drawCourses()
    {
        pixels::TextPanel& sheet = *bottomLeft;
        sheet.clear();
        sheet.strokes().rectangle({kMargin, kMargin}, {kMargin + 226.0F, kMargin + 112.0F}, kPanel);
        error.draw(sheet, {kMargin + 8.0F, kMargin + 64.0F}, {132.0F, 28.0F});
        latency.draw(sheet, {kMargin + 8.0F, kMargin + 8.0F}, {132.0F, 28.0F});
        sheet.finish();
    }

    /// Draws the colour scales from the bottom up, without those whose range is 0.
    void drawScales(float field_Pa, float volume_Pa)
    {
        std::vector<pixels::Scale> scales;
        const auto add = [&](const ColorMap& map, const char* heading, float height)
        {
            pixels::Scale scale;
            scale.map = &map;
            scale.heading = heading;
            scale.size = {14.0F, height};
            scales.push_back(scale);
            return &scales.back();
        };
        add(ColorMap::phase(), "drive phase", 56.0F)->labels = {
            {0.0, "0"}, {0.5, "180°"}, {1.0, "360°"}};
        add(ColorMap::diverging(), "got / wanted", 76.0F)->labels = {
            {0.0, "50 %"}, {0.5, "100 %"}, {1.0, "200 %"}};
        if (volume_Pa > 0.0F)
            add(ColorMap::radiation(), "radiation, Pa", 84.0F)->label(volume_Pa, 5);
        if (field_Pa > 0.0F)
            add(ColorMap::pressure(), "|p| (peak), Pa", 118.0F)->label(field_Pa, 6);
        pixels::TextPanel& sheet = *bottomRight;
        sheet.clear();
        float y = kMargin + 14.0F;
        for (pixels::Scale& scale : scales)
        {
            scale.lowerLeft = {-kMargin - 96.0F, y};
            y += scale.size.y() + 40.0F;
        }
        sheet.strokes().rectangle({-kMargin - 104.0F, kMargin}, {-kMargin, y - 14.0F}, kPanel);
        for (const pixels::Scale& scale : scales)
            scale.draw(sheet, 12.0F, kBright);
        sheet.finish();
    }

    osg::ref_ptr<pixels::TextPanel> topLeft;
    osg::ref_ptr<pixels::TextPanel> bottomLeft;
    osg::ref_ptr<pixels::TextPanel> bottomRight;
    std::string title = "osgMidair";
    pixels::Sparkline error;
    pixels::Sparkline latency;
};

/// Adds rows with counts of work that was not needed since the start, without counts of 0.
void addSpared(std::vector<std::pair<std::string, std::string>>& rows,
               const midair::bridge::HologramCounters& counters)
{
    const auto line = [](std::initializer_list<std::pair<std::uint64_t, const char*>> counts)
    {
        std::vector<std::string> texts;
        for (const auto& [count, what] : counts)
            if (count > 0) texts.push_back(pixels::number(static_cast<double>(count)) + what);
        return fmt::format("{}", fmt::join(texts, ", "));
    };
    const std::string left = line({{counters.rowsKept, " unmoved"},
                                   {counters.outOfWorkspace, " outside"},
                                   {counters.outOfReach, " out of reach"},
                                   {counters.overBudget, " over budget"},
                                   {counters.crowded, " crowded"},
                                   {counters.unpainted, " unpainted"}});
    if (!left.empty()) rows.emplace_back("points spared", left);
    const std::string fields =
        line({{counters.skippedUnmoved, " unmoved"}, {counters.superseded, " overtaken"}});
    if (!fields.empty()) rows.emplace_back("fields spared", fields);
    const std::string meshes =
        line({{counters.meshesSampled, " sampled"}, {counters.meshesFollowed, " followed"}});
    if (!meshes.empty()) rows.emplace_back("meshes", meshes);
}

} // namespace

class Hud::Part : public OverlayPart
{
public:
    void setResult(const std::shared_ptr<const midair::bridge::HologramResult>& result) override;
    /// Called in every frame; updates the figures once per interval.
    void update();

    Panel panel;
    osg::observer_ptr<FieldSliceOverlay> slice;
    osg::observer_ptr<FieldVolumeOverlay> volume;
    double updateInterval_s = 0.25;
    double frameRate = 0.0;

private:
    std::shared_ptr<const midair::bridge::HologramResult> _result;
    double _lastUpdate_s = 0.0;
    int _frames = 0;
};

Hud::Hud() : Overlay(std::make_unique<Part>()), _part(static_cast<Part&>(OverlayPart::of(*this)))
{
    addChild(_part.panel.topLeft);
    addChild(_part.panel.bottomLeft);
    addChild(_part.panel.bottomRight);
    pixels::paintInOrder(*this, HUD_BIN);
    setNumChildrenRequiringUpdateTraversal(1);
}

Hud::~Hud() = default;

void Hud::setTitle(const std::string& title)
{
    _part.panel.title = title;
}

void Hud::setScale(float scale)
{
    _scale = scale;
}

void Hud::setFieldSlice(FieldSliceOverlay* slice)
{
    _part.slice = slice;
}

void Hud::setFieldVolume(FieldVolumeOverlay* volume)
{
    _part.volume = volume;
}

double Hud::getUpdateInterval() const
{
    return _part.updateInterval_s;
}

void Hud::setUpdateInterval(double interval_s)
{
    _part.updateInterval_s = interval_s;
}

double Hud::getFrameRate() const
{
    return _part.frameRate;
}

void Hud::Part::setResult(const std::shared_ptr<const midair::bridge::HologramResult>& result)
{
    _result = result;
    panel.error.add(100.0 * result->report().rms);
    panel.latency.add(result->latency_ms);
}

void Hud::Part::update()
{
    ++_frames;
    const double now = midair::base::steadySeconds();
    if (now - _lastUpdate_s < updateInterval_s || !_result) return;
    if (_lastUpdate_s > 0.0) frameRate = _frames / (now - _lastUpdate_s);
    _frames = 0;
    _lastUpdate_s = now;
    const midair::bridge::HologramResult& r = *_result;
    const midair::haptics::SolveReport& report = r.report();
    osg::ref_ptr<FieldSliceOverlay> fieldSlice;
    osg::ref_ptr<FieldVolumeOverlay> fieldVolume;
    slice.lock(fieldSlice);
    volume.lock(fieldVolume);
    const bool sliceShown = fieldSlice && fieldSlice->isShown();
    const bool volumeShown = fieldVolume && fieldVolume->isShown();
    Panel::Rows rows;
    rows.emplace_back("control points",
                      fmt::format("{}, {} left out", report.points, r.skipped.cols()));
    rows.emplace_back("solve",
                      fmt::format("{:.2f} ms (matrix {:.2f})",
                                  report.matrix_ms + report.solve_ms,
                                  report.matrix_ms));
    rows.emplace_back("updates", fmt::format("{:.0f} / s", r.updatesPerSecond));
    addSpared(rows, r.counters);
    rows.emplace_back("error rms, max",
                      fmt::format("{:.2f} %, {:.2f} %", 100.0 * report.rms, 100.0 * report.max));
    rows.emplace_back("loudness E", fmt::format("{:.3f}", report.loudness));
    if (r.monitored && r.monitored->certificate.points > 0)
        rows.emplace_back(
            "off the best",
            fmt::format("{:.1f} % at most", 100.0 * r.monitored->certificate.gapOfPhases()));
    if (r.report().surface.samples > 0)
        rows.emplace_back("surface cv",
                          fmt::format("{:.2f}", r.report().surface.coefficientOfVariation));
    rows.emplace_back("pressure", pixels::number(std::round(report.level_Pa)) + " Pa (peak)");
    rows.emplace_back("latency", fmt::format("{:.1f} ms", r.latency_ms));
    if (sliceShown)
        rows.emplace_back("slice", fmt::format("{:.0f} / s", fieldSlice->getSlicesPerSecond()));
    if (volumeShown)
        rows.emplace_back("volume", fmt::format("{:.0f} / s", fieldVolume->getVolumesPerSecond()));
    rows.emplace_back("frames", frameRate > 0.0 ? fmt::format("{:.0f} / s", frameRate) : "-");
    rows.emplace_back("device", r.deviceStatus);
    panel.drawFigures(rows, !r.messages.empty() ? r.messages.back() : report.message);
    panel.drawCourses();
    panel.drawScales(sliceShown ? fieldSlice->getRange() : 0.0F,
                     volumeShown ? fieldVolume->getRange() : 0.0F);
}

// The HUD takes no space in the scene. The bounds of the sheets are computed here all the same, on
// a single thread, as views that cull at the same time would each compute them.
osg::BoundingSphere Hud::computeBound() const
{
    Overlay::computeBound();
    return {};
}

void Hud::traverse(osg::NodeVisitor& visitor)
{
    if (visitor.getVisitorType() == osg::NodeVisitor::UPDATE_VISITOR) _part.update();
    osgUtil::CullVisitor* cull = visitor.asCullVisitor();
    if (!cull || !cull->getViewport()) return;
    // The scene graph is not changed here, as views may cull at the same time: each pushes its own
    // matrices.
    const double pixels = cull->getViewport()->height();
    const double scale = _scale > 0.0F ? _scale : std::max(1.0, 0.5 * std::floor(pixels / 350.0));
    const double width = cull->getViewport()->width() / scale;
    const double height = pixels / scale;
    const osg::CullSettings::ComputeNearFarMode mode = cull->getComputeNearFarMode();
    cull->setComputeNearFarMode(osg::CullSettings::DO_NOT_COMPUTE_NEAR_FAR);
    cull->pushProjectionMatrix(new osg::RefMatrix(osg::Matrix::ortho2D(0.0, width, 0.0, height)));
    const auto draw = [&](osg::Group& group, double x, double y)
    {
        cull->pushModelViewMatrix(new osg::RefMatrix(osg::Matrix::translate(x, y, 0.0)),
                                  osg::Transform::ABSOLUTE_RF);
        group.accept(visitor);
        cull->popModelViewMatrix();
    };
    draw(*_part.panel.topLeft, 0.0, height);
    draw(*_part.panel.bottomLeft, 0.0, 0.0);
    draw(*_part.panel.bottomRight, width, 0.0);
    cull->popProjectionMatrix();
    cull->setComputeNearFarMode(mode);
}

} // namespace osgMidair
