#include "engine-bridge/HologramResult.h"
#include "plugin/overlays/Flat.h"
#include "plugin/overlays/Quads.h"
#include "plugin/overlays/Sparkline.h"

#include <osgMidair/Hud>

#include <osgUtil/CullVisitor>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdarg>
#include <cstdio>

namespace osgMidair
{

namespace
{

const osg::Vec4 kBright(0.96F, 0.97F, 0.99F, 1.0F);
const osg::Vec4 kDim(0.68F, 0.72F, 0.78F, 1.0F);
const osg::Vec4 kWarning(1.0F, 0.80F, 0.35F, 1.0F);
const osg::Vec4 kPanel(0.085F, 0.10F, 0.125F, 0.72F);
constexpr float kTextSize = 13.0F;
constexpr float kPanelWidth = 300.0F;
constexpr float kPanelHeight = 200.0F;
constexpr float kMargin = 12.0F;
const char* const kNames =
    "control points\nsolve\nupdates\nerror rms, max\nloudness E\npressure\nlatency\nslice\n"
    "frames\ndevice";

double now_s()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...)
{
    char buffer[160];
    std::va_list arguments;
    va_start(arguments, pattern);
    std::vsnprintf(buffer, sizeof buffer, pattern, arguments);
    va_end(arguments);
    return buffer;
}

std::string shortened(const std::string& line, std::size_t most)
{
    return line.size() <= most ? line : line.substr(0, most - 2) + "..";
}

} // namespace

/// The drawing: one group for each corner of the viewport that it keeps to.
class Hud::Panel
{
public:
    Panel()
    {
        topLeft = new osg::Group;
        topLeft->addChild(flat::rectangle(
            {kMargin, -kMargin - kPanelHeight}, {kMargin + kPanelWidth, -kMargin}, kPanel));
        const float x = kMargin + 10.0F;
        float y = -kMargin - 22.0F;
        title = flat::text("osgMidair", {x, y}, kTextSize + 1.0F, kBright);
        y -= 20.0F;
        names = flat::text(kNames, {x, y}, kTextSize, kDim);
        values = flat::text("", {x + 104.0F, y}, kTextSize, kBright);
        message = flat::text("", {x, -kMargin - kPanelHeight - 18.0F}, kTextSize, kWarning);
        for (const osg::ref_ptr<osgText::Text>& text : {title, names, values, message})
        {
            text->setLineSpacing(0.12F);
            topLeft->addChild(text);
        }

        bottomLeft = new osg::Group;
        bottomLeft->addChild(
            flat::rectangle({kMargin, kMargin}, {kMargin + 232.0F, kMargin + 122.0F}, kPanel));
        error = new flat::Sparkline(
            "error rms", "%", {kMargin + 10.0F, kMargin + 70.0F}, {140.0F, 30.0F});
        latency = new flat::Sparkline(
            "latency", "ms", {kMargin + 10.0F, kMargin + 12.0F}, {140.0F, 30.0F});
        bottomLeft->addChild(error);
        bottomLeft->addChild(latency);

        bottomRight = new osg::Group;
        flat::ColorBar::Layout layout;
        layout.textSize = 12.0F;
        layout.textColor = kBright;
        const auto addBar =
            [&](const ColorMap& map, const std::string& heading, float y0, float height)
        {
            layout.lowerLeft = {-104.0F, y0};
            layout.size = {14.0F, height};
            const osg::ref_ptr<flat::ColorBar> bar = new flat::ColorBar(map, heading, layout);
            bottomRight->addChild(bar);
            return bar;
        };
        bottomRight->addChild(
            flat::rectangle({-kMargin - 104.0F, kMargin}, {-kMargin, kMargin + 418.0F}, kPanel));
        const osg::ref_ptr<flat::ColorBar> phase =
            addBar(ColorMap::phase(), "drive phase", 30.0F, 66.0F);
        phase->setLabels({{0.0, "0"}, {0.5, "180°"}, {1.0, "360°"}});
        const osg::ref_ptr<flat::ColorBar> ratio =
            addBar(ColorMap::diverging(), "got / wanted", 136.0F, 84.0F);
        ratio->setLabels({{0.0, "50 %"}, {0.5, "100 %"}, {1.0, "200 %"}});
        field = addBar(ColorMap::pressure(), "|p| in Pa", 260.0F, 136.0F);
    }

    osg::ref_ptr<osg::Group> topLeft;
    osg::ref_ptr<osg::Group> bottomLeft;
    osg::ref_ptr<osg::Group> bottomRight;
    osg::ref_ptr<osgText::Text> title;
    osg::ref_ptr<osgText::Text> names;
    osg::ref_ptr<osgText::Text> values;
    osg::ref_ptr<osgText::Text> message;
    osg::ref_ptr<flat::Sparkline> error;
    osg::ref_ptr<flat::Sparkline> latency;
    osg::ref_ptr<flat::ColorBar> field;
};

Hud::Hud() : _panel(std::make_unique<Panel>())
{
    addChild(_panel->topLeft);
    addChild(_panel->bottomLeft);
    addChild(_panel->bottomRight);
    flat::paintInOrder(*this, HUD_BIN);
    setNumChildrenRequiringUpdateTraversal(1);
}

Hud::~Hud() = default;

void Hud::setTitle(const std::string& title)
{
    _panel->title->setText(shortened(title, 42), osgText::String::ENCODING_UTF8);
}

void Hud::setScale(float scale)
{
    _scale = scale;
}

void Hud::setFieldSlice(FieldSliceOverlay* slice)
{
    _slice = slice;
}

void Hud::setUpdateInterval(double interval_s)
{
    _updateInterval_s = interval_s;
}

double Hud::getFrameRate() const
{
    return _frameRate;
}

void Hud::setResult(const std::shared_ptr<const midair::bridge::HologramResult>& result)
{
    _result = result;
    _panel->error->add(100.0 * result->report.rms);
    _panel->latency->add(result->latency_ms);
}

void Hud::update()
{
    ++_frames;
    const double now = now_s();
    if (now - _lastUpdate_s < _updateInterval_s || !_result) return;
    if (_lastUpdate_s > 0.0) _frameRate = _frames / (now - _lastUpdate_s);
    _frames = 0;
    _lastUpdate_s = now;
    const midair::haptics::SolveReport& report = _result->report;
    osg::ref_ptr<FieldSliceOverlay> slice;
    _slice.lock(slice);
    std::string values = format("%d", report.points);
    values +=
        format("\n%.2f ms (matrix %.2f)", report.matrix_ms + report.solve_ms, report.matrix_ms);
    values += format("\n%.0f / s", _result->updatesPerSecond);
    values += format("\n%.2f %%, %.2f %%", 100.0 * report.rms, 100.0 * report.max);
    values += format("\n%.3f", report.loudness);
    values += "\n" + flat::number(std::round(report.level_Pa)) + " Pa (peak)";
    values += format("\n%.1f ms", _result->latency_ms);
    values +=
        slice && slice->isShown()
            ? format("\n%.1f ms, %.0f / s", slice->getComputeTime_ms(), slice->getSlicesPerSecond())
            : std::string("\noff");
    values += _frameRate > 0.0 ? format("\n%.0f / s", _frameRate) : std::string("\n-");
    values += "\n" + shortened(_result->deviceStatus, 27);
    _panel->values->setText(values, osgText::String::ENCODING_UTF8);
    const std::string message =
        !_result->messages.empty() ? _result->messages.back() : report.message;
    _panel->message->setText(shortened(message, 90), osgText::String::ENCODING_UTF8);
    _panel->error->redraw();
    _panel->latency->redraw();
    if (slice && slice->getRange() > 0.0F) _panel->field->setRange(0.0, slice->getRange());
}

void Hud::traverse(osg::NodeVisitor& visitor)
{
    if (visitor.getVisitorType() == osg::NodeVisitor::UPDATE_VISITOR) update();
    osgUtil::CullVisitor* cull = visitor.asCullVisitor();
    if (!cull || !cull->getViewport()) return;
    // Nothing of the scene graph is changed here: views that cull at the same time each push matrices of their own.
    const double pixels = cull->getViewport()->height();
    const double scale = _scale > 0.0F ? _scale : std::max(1.0, std::floor(pixels / 700.0));
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
    draw(*_panel->topLeft, 0.0, height);
    draw(*_panel->bottomLeft, 0.0, 0.0);
    draw(*_panel->bottomRight, width, 0.0);
    cull->popProjectionMatrix();
    cull->setComputeNearFarMode(mode);
}

} // namespace osgMidair
