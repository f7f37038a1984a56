#include "samples/views/CurvePlot.h"

#include "samples/views/Offscreen.h"
#include "samples/views/PlotSheet.h"

#include <osgDB/WriteFile>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace midair::samples
{

namespace
{

// Pixels.
constexpr float kPanelWidth = 900.0F;
constexpr float kPanelHeight = 280.0F;
constexpr float kLeft = 110.0F;
constexpr float kRight = 30.0F;
constexpr float kTop = 70.0F;
constexpr float kBetween = 100.0F;
constexpr float kBottom = 95.0F;
constexpr float kTextSize = 17.0F;
constexpr float kMark = 5.0F;

// What hides what: nearer is larger.
constexpr float kTint = -0.8F;
constexpr float kBehind = -0.5F;
constexpr float kMiddles = -0.2F;
constexpr float kCurves = 0.0F;
constexpr float kMarks = 0.2F;
constexpr float kHoles = 0.3F;
constexpr float kFrame = 0.5F;

const osg::Vec4 kPaper(1.0F, 1.0F, 1.0F, 1.0F);
const osg::Vec4 kInk(0.1F, 0.1F, 0.12F, 1.0F);
const osg::Vec4 kGrid(0.86F, 0.87F, 0.88F, 1.0F);
// Told apart by people who see red and green alike, too (Okabe, Ito 2008).
const std::array<osg::Vec4, 6> kColors = {osg::Vec4(0.00F, 0.45F, 0.70F, 1.0F),
                                          osg::Vec4(0.84F, 0.37F, 0.00F, 1.0F),
                                          osg::Vec4(0.00F, 0.62F, 0.45F, 1.0F),
                                          osg::Vec4(0.80F, 0.47F, 0.65F, 1.0F),
                                          osg::Vec4(0.34F, 0.71F, 0.91F, 1.0F),
                                          osg::Vec4(0.55F, 0.45F, 0.05F, 1.0F)};

struct Range
{
    double low, high;
    double share(double value) const { return (value - low) / (high - low); }
};

std::string numberText(double value)
{
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%g", std::fabs(value) < 1e-12 ? 0.0 : value);
    return text.data();
}

/// A panel with its lower left corner in pixels, and what its edges stand for.
class Axes
{
public:
    Axes(const CurvePanel& panel, const osg::Vec2& corner) : _panel(panel), _corner(corner)
    {
        double top = 0.0, bottom = 0.0, first = INFINITY, last = -INFINITY;
        for (const Curve& curve : panel.curves)
        {
            top = std::max(top, curve.y.maxCoeff());
            bottom = std::min(bottom, curve.y.minCoeff());
            first = std::min(first, curve.x[0]);
            last = std::max(last, curve.x[curve.x.size() - 1]);
        }
        if (std::isfinite(panel.xLow)) first = panel.xLow;
        if (std::isfinite(panel.xHigh)) last = panel.xHigh;
        if (std::isfinite(panel.yHigh)) top = panel.yHigh / 1.05;
        if (!(last > first)) last = first + 1.0;
        if (!(top > bottom)) top = bottom + 1.0;
        _x = {first, last};
        _y = {bottom, bottom + 1.05 * (top - bottom)};
        if (!panel.logarithmic) return;
        const double decade = std::ceil(std::log10(top > 0.0 ? top : 1.0));
        _y = {decade - std::max(panel.decades, 1), decade};
    }

    void draw(PlotSheet& sheet) const
    {
        drawBands(sheet);
        drawGrid(sheet);
        for (std::size_t k = 0; k < _panel.curves.size(); ++k)
            drawCurve(sheet, _panel.curves[k], colorOf(_panel.curves[k], k));
        drawLegend(sheet);
        sheet.line({at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0), at(0.0, 0.0)},
                   kInk,
                   1.0F,
                   kFrame);
        sheet.text(_panel.xName,
                   at(0.5, 0.0) + osg::Vec2(0.0F, -34.0F),
                   osgText::TextBase::CENTER_TOP,
                   kTextSize,
                   kInk);
        sheet.text(_panel.yName,
                   at(0.0, 0.5) + osg::Vec2(-75.0F, 0.0F),
                   osgText::TextBase::CENTER_BASE_LINE,
                   kTextSize,
                   kInk,
                   true);
    }

private:
    osg::Vec2 at(double across, double up) const
    {
        return _corner + osg::Vec2(static_cast<float>(across) * kPanelWidth,
                                   static_cast<float>(up) * kPanelHeight);
    }

    static const osg::Vec4& colorOf(const Curve& curve, std::size_t place)
    {
        const std::size_t color = curve.color < 0 ? place : static_cast<std::size_t>(curve.color);
        return kColors[color % kColors.size()];
    }

    static osg::Vec4 tinted(const CurveBand& band)
    {
        const osg::Vec4& color = kColors[static_cast<std::size_t>(band.color) % kColors.size()];
        osg::Vec4 light = kPaper * 0.82F + color * 0.18F;
        light.a() = 1.0F;
        return light;
    }

    void drawBands(PlotSheet& sheet) const
    {
        for (const CurveBand& band : _panel.bands)
        {
            const auto share = [&](double value)
            { return band.isOfX ? std::clamp(_x.share(value), 0.0, 1.0) : heightOf(value); };
            const auto place = [&](double along, double across)
            { return band.isOfX ? at(along, across) : at(across, along); };
            sheet.rectangle(
                place(share(band.low), 0.0), place(share(band.high), 1.0), tinted(band), kTint);
            if (!std::isfinite(band.middle)) continue;
            const double middle = share(band.middle);
            sheet.line({place(middle, 0.0), place(middle, 1.0)},
                       kColors[static_cast<std::size_t>(band.color) % kColors.size()],
                       1.3F,
                       kMiddles);
        }
    }

    void drawCurve(PlotSheet& sheet, const Curve& curve, const osg::Vec4& color) const
    {
        if (curve.isJoined) sheet.line(thinned(curve), color, 1.3F, kCurves);
        if (curve.mark == CurveMark::NONE) return;
        for (Eigen::Index k = 0; k < curve.x.size(); ++k)
            drawMark(sheet, at(_x.share(curve.x[k]), heightOf(curve.y[k])), curve.mark, color);
    }

    static void
    drawMark(PlotSheet& sheet, const osg::Vec2& at, CurveMark mark, const osg::Vec4& color)
    {
        sheet.disc(at, kMark, color, kMarks);
        if (mark == CurveMark::RING) sheet.disc(at, 0.62F * kMark, kPaper, kHoles);
    }

    // Names in the colour of what they name, beside each other.
    void drawLegend(PlotSheet& sheet) const
    {
        float x = 10.0F;
        const auto name = [&](const std::string& text, const osg::Vec4& color)
        {
            sheet.text(text,
                       _corner + osg::Vec2(x, kPanelHeight + 8.0F),
                       osgText::TextBase::LEFT_BOTTOM_BASE_LINE,
                       kTextSize,
                       color);
            x += sheet.widthOf(text, kTextSize) + 24.0F;
        };
        for (std::size_t k = 0; k < std::min(_panel.curves.size(), kColors.size()); ++k)
        {
            const Curve& curve = _panel.curves[k];
            if (curve.name.empty()) continue;
            if (curve.mark != CurveMark::NONE)
            {
                drawMark(sheet,
                         _corner + osg::Vec2(x + kMark, kPanelHeight + 14.0F),
                         curve.mark,
                         colorOf(curve, k));
                x += 2.0F * kMark + 6.0F;
            }
            name(curve.name, colorOf(curve, k));
        }
        for (const CurveBand& band : _panel.bands)
            if (!band.name.empty())
                name(band.name, kColors[static_cast<std::size_t>(band.color) % kColors.size()]);
    }

    double heightOf(double value) const
    {
        if (_panel.logarithmic) value = value > 0.0 ? std::log10(value) : _y.low;
        return std::clamp(_y.share(value), 0.0, 1.0);
    }

    void drawTick(PlotSheet& sheet, double tick, const std::string& name) const
    {
        const double share = _x.share(tick);
        if (_panel.xTicks.empty())
            sheet.line({at(share, 0.0), at(share, 1.0)}, kGrid, 1.0F, kBehind);
        sheet.text(name,
                   at(share, 0.0) + osg::Vec2(0.0F, -21.0F),
                   osgText::TextBase::CENTER_BASE_LINE,
                   kTextSize,
                   kInk);
    }

    void drawGrid(PlotSheet& sheet) const
    {
        for (const auto& [place, name] : _panel.xTicks)
            drawTick(sheet, place, name);
        const double across = tickStep(_x.high - _x.low, 10);
        for (double tick = across * std::ceil(_x.low / across - 1e-9);
             _panel.xTicks.empty() && tick <= _x.high + 1e-9 * across;
             tick += across)
            drawTick(sheet, tick, numberText(tick));
        const double up = _panel.logarithmic ? 1.0 : tickStep(_y.high - _y.low, 6);
        for (double tick = up * std::ceil(_y.low / up - 1e-9); tick <= _y.high + 1e-9 * up;
             tick += up)
        {
            const double share = _y.share(tick);
            sheet.line({at(0.0, share), at(1.0, share)}, kGrid, 1.0F, kBehind);
            sheet.text(numberText(_panel.logarithmic ? std::pow(10.0, std::round(tick)) : tick),
                       at(0.0, share) + osg::Vec2(-8.0F, 0.0F),
                       osgText::TextBase::RIGHT_CENTER,
                       kTextSize,
                       kInk);
        }
    }

    // Where several points share a column of half a pixel, its lowest and its highest in their
    // order.
    std::vector<osg::Vec2> thinned(const Curve& curve) const
    {
        std::vector<osg::Vec2> places;
        const auto columnOf = [&](Eigen::Index k)
        { return static_cast<int>(2.0 * kPanelWidth * _x.share(curve.x[k])); };
        for (Eigen::Index k = 0; k < curve.x.size();)
        {
            Eigen::Index low = k, high = k, end = k;
            for (; end < curve.x.size() && columnOf(end) == columnOf(k); ++end)
            {
                if (curve.y[end] < curve.y[low]) low = end;
                if (curve.y[end] > curve.y[high]) high = end;
            }
            for (const Eigen::Index of : {std::min(low, high), std::max(low, high)})
                places.push_back(at(_x.share(curve.x[of]), heightOf(curve.y[of])));
            k = end;
        }
        return places;
    }

    const CurvePanel& _panel;
    osg::Vec2 _corner;
    Range _x{}, _y{};
};

std::string problemOf(const CurvePlot& plot)
{
    if (plot.panels.empty()) return "there are no panels to draw";
    for (const CurvePanel& panel : plot.panels)
    {
        if (panel.curves.empty()) return "a panel has no curves";
        for (const Curve& curve : panel.curves)
            if (curve.x.size() == 0 || curve.x.size() != curve.y.size() || !curve.x.allFinite() ||
                !curve.y.allFinite())
                return "a curve has no points, not as many x as y, or numbers that are not finite";
        for (const CurveBand& band : panel.bands)
            if (!(band.low <= band.high) || !std::isfinite(band.low) || !std::isfinite(band.high))
                return "a band has no range";
    }
    return {};
}

} // namespace

double tickStep(double range, int most)
{
    const double least = range / most;
    const double power = std::pow(10.0, std::floor(std::log10(least)));
    for (const double step : {1.0, 2.0, 5.0})
        if (step * power >= least * (1.0 - 1e-9)) return step * power;
    return 10.0 * power;
}

bool writeCurvePlot(const std::string& path, const CurvePlot& plot, std::string* message)
{
    std::string problem = problemOf(plot);
    if (message) *message = problem;
    if (!problem.empty()) return false;
    const auto panels = static_cast<float>(plot.panels.size());
    const float width = kLeft + kPanelWidth + kRight;
    const float height = kBottom + panels * kPanelHeight + (panels - 1.0F) * kBetween + kTop;
    PlotSheet sheet;
    float top = height - kTop;
    for (const CurvePanel& panel : plot.panels)
    {
        Axes(panel, osg::Vec2(kLeft, top - kPanelHeight)).draw(sheet);
        top -= kPanelHeight + kBetween;
    }
    sheet.text(plot.title,
               osg::Vec2(kLeft, height - 24.0F),
               osgText::TextBase::LEFT_CENTER,
               1.2F * kTextSize,
               kInk);
    sheet.text(
        plot.caption, osg::Vec2(kLeft, 16.0F), osgText::TextBase::LEFT_CENTER, kTextSize, kInk);
    const osg::ref_ptr<osg::Image> drawn = renderFlat(
        sheet.root(), static_cast<int>(width), static_cast<int>(height), kPaper, &problem);
    if (!drawn)
        problem = path + " isn't drawn: " + problem;
    else if (!osgDB::writeImageFile(*drawn, path))
        problem = "can't write the picture " + path + " (is the folder there, and is it a .png?)";
    if (message) *message = problem;
    return problem.empty();
}

} // namespace midair::samples
