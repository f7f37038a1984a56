#include "samples/views/CurvePlot.h"

#include "samples/views/LabelFont.h"
#include "samples/views/Offscreen.h"

#include <osg/Geode>
#include <osg/Geometry>
#include <osg/LineWidth>
#include <osgDB/WriteFile>
#include <osgText/Font>
#include <osgText/Text>

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

// What hides what: nearer is larger.
constexpr float kBehind = -0.5F;
constexpr float kCurves = 0.0F;
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

/// What is drawn, in pixels from the lower left.
class Sheet
{
public:
    void text(const std::string& content,
              const osg::Vec2& at,
              osgText::TextBase::AlignmentType alignment,
              float size = kTextSize,
              const osg::Vec4& color = kInk,
              bool upright = false)
    {
        const osg::ref_ptr<osgText::Text> made = new osgText::Text;
        made->setFont(_font);
        made->setFontResolution(40, 40);
        made->setCharacterSize(size);
        made->setPosition(osg::Vec3(at, 0.0F));
        made->setColor(color);
        made->setAlignment(alignment);
        made->setText(content, osgText::String::ENCODING_UTF8);
        if (upright)
        {
            made->setAxisAlignment(osgText::TextBase::USER_DEFINED_ROTATION);
            made->setRotation(osg::Quat(osg::PI_2, osg::Z_AXIS));
        }
        _root->addChild(made);
    }

    void line(const std::vector<osg::Vec2>& places, const osg::Vec4& color, float width, float z)
    {
        const osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
        for (const osg::Vec2& place : places)
            vertices->push_back(osg::Vec3(place, z));
        const osg::ref_ptr<osg::Vec4Array> colors = new osg::Vec4Array(1, &color);
        const osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
        geometry->setVertexArray(vertices);
        geometry->setColorArray(colors, osg::Array::BIND_OVERALL);
        geometry->addPrimitiveSet(
            new osg::DrawArrays(GL_LINE_STRIP, 0, static_cast<GLsizei>(vertices->size())));
        // The sheet is drawn twice as large and averaged down.
        geometry->getOrCreateStateSet()->setAttributeAndModes(new osg::LineWidth(2.0F * width));
        _root->addChild(geometry);
    }

    osg::Group& root() { return *_root; }

private:
    osg::ref_ptr<osg::Group> _root = new osg::Group;
    osg::ref_ptr<osgText::Font> _font = labelFont();
};

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
        if (!(last > first)) last = first + 1.0;
        if (!(top > bottom)) top = bottom + 1.0;
        _x = {first, last};
        _y = {bottom, bottom + 1.05 * (top - bottom)};
        if (!panel.logarithmic) return;
        const double decade = std::ceil(std::log10(top > 0.0 ? top : 1.0));
        _y = {decade - std::max(panel.decades, 1), decade};
    }

    void draw(Sheet& sheet) const
    {
        drawGrid(sheet);
        for (std::size_t k = 0; k < _panel.curves.size(); ++k)
        {
            const osg::Vec4& color = kColors[k % kColors.size()];
            sheet.line(thinned(_panel.curves[k]), color, 1.3F, kCurves);
            const osg::Vec2 legend =
                _corner + osg::Vec2(10.0F + 145.0F * static_cast<float>(k % kColors.size()),
                                    kPanelHeight + 8.0F);
            if (k < kColors.size())
                sheet.text(_panel.curves[k].name,
                           legend,
                           osgText::TextBase::LEFT_BOTTOM_BASE_LINE,
                           kTextSize,
                           color);
        }
        sheet.line({at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0), at(0.0, 0.0)},
                   kInk,
                   1.0F,
                   kFrame);
        sheet.text(
            _panel.xName, at(0.5, 0.0) + osg::Vec2(0.0F, -34.0F), osgText::TextBase::CENTER_TOP);
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

    double heightOf(double value) const
    {
        if (_panel.logarithmic) value = value > 0.0 ? std::log10(value) : _y.low;
        return std::clamp(_y.share(value), 0.0, 1.0);
    }

    void drawGrid(Sheet& sheet) const
    {
        const double across = tickStep(_x.high - _x.low, 10);
        for (double tick = across * std::ceil(_x.low / across - 1e-9);
             tick <= _x.high + 1e-9 * across;
             tick += across)
        {
            const double share = _x.share(tick);
            sheet.line({at(share, 0.0), at(share, 1.0)}, kGrid, 1.0F, kBehind);
            sheet.text(numberText(tick),
                       at(share, 0.0) + osg::Vec2(0.0F, -8.0F),
                       osgText::TextBase::CENTER_TOP);
        }
        const double up = _panel.logarithmic ? 1.0 : tickStep(_y.high - _y.low, 6);
        for (double tick = up * std::ceil(_y.low / up - 1e-9); tick <= _y.high + 1e-9 * up;
             tick += up)
        {
            const double share = _y.share(tick);
            sheet.line({at(0.0, share), at(1.0, share)}, kGrid, 1.0F, kBehind);
            sheet.text(numberText(_panel.logarithmic ? std::pow(10.0, std::round(tick)) : tick),
                       at(0.0, share) + osg::Vec2(-8.0F, 0.0F),
                       osgText::TextBase::RIGHT_CENTER);
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
    Sheet sheet;
    float top = height - kTop;
    for (const CurvePanel& panel : plot.panels)
    {
        Axes(panel, osg::Vec2(kLeft, top - kPanelHeight)).draw(sheet);
        top -= kPanelHeight + kBetween;
    }
    sheet.text(plot.title,
               osg::Vec2(kLeft, height - 24.0F),
               osgText::TextBase::LEFT_CENTER,
               1.2F * kTextSize);
    sheet.text(plot.caption, osg::Vec2(kLeft, 16.0F), osgText::TextBase::LEFT_CENTER);
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
