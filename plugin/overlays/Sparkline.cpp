#include "plugin/overlays/Sparkline.h"

#include <osg/LineWidth>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace osgMidair::flat
{

namespace
{

const osg::Vec4 kCurve(0.55F, 0.85F, 0.95F, 1.0F);
const osg::Vec4 kDim(0.68F, 0.72F, 0.78F, 1.0F);
constexpr float kTextSize = 12.0F;

std::string withUnit(double value, const std::string& unit)
{
    char digits[48];
    std::snprintf(digits,
                  sizeof digits,
                  value < 1.0     ? "%.2f %s"
                  : value < 100.0 ? "%.1f %s"
                                  : "%.0f %s",
                  value,
                  unit.c_str());
    return digits;
}

} // namespace

Sparkline::Sparkline(const std::string& name,
                     const std::string& unit,
                     const osg::Vec2& lowerLeft,
                     const osg::Vec2& size) :
    _unit(unit),
    _lowerLeft(lowerLeft),
    _size(size),
    _curve(new osg::Geometry)
{
    Strokes base;
    base.line(lowerLeft, lowerLeft + osg::Vec2(size.x(), 0.0F), 1.0F, {0.45F, 0.48F, 0.54F, 0.8F});
    addChild(base.geometry());
    _curve->setDataVariance(DYNAMIC);
    _curve->setUseDisplayList(false);
    _curve->setUseVertexBufferObjects(true);
    _curve->setCullingActive(false);
    _curve->setVertexArray(new osg::Vec3Array);
    _curve->setColorArray(new osg::Vec4Array(1, &kCurve), osg::Array::BIND_OVERALL);
    _curve->addPrimitiveSet(new osg::DrawArrays(GL_LINE_STRIP, 0, 0));
    _curve->getOrCreateStateSet()->setAttributeAndModes(new osg::LineWidth(1.5F));
    addChild(_curve);
    addChild(text(name, lowerLeft + osg::Vec2(0.0F, size.y() + 5.0F), kTextSize, kDim));
    _last = text("",
                 lowerLeft + osg::Vec2(size.x(), size.y() + 5.0F),
                 kTextSize,
                 {1.0F, 1.0F, 1.0F, 1.0F},
                 osgText::TextBase::RIGHT_BASE_LINE);
    _most = text("",
                 lowerLeft + osg::Vec2(size.x() + 6.0F, size.y()),
                 0.85F * kTextSize,
                 kDim,
                 osgText::TextBase::LEFT_TOP);
    addChild(_last);
    addChild(_most);
}

void Sparkline::add(double value)
{
    if (!std::isfinite(value)) return;
    _values.push_back(value);
    if (_values.size() > kValues) _values.pop_front();
}

void Sparkline::redraw()
{
    if (_values.empty()) return;
    const double most = std::max(1e-9, *std::max_element(_values.begin(), _values.end()));
    auto& vertices = static_cast<osg::Vec3Array&>(*_curve->getVertexArray());
    vertices.clear();
    for (std::size_t i = 0; i < _values.size(); ++i)
        vertices.push_back(osg::Vec3(
            _lowerLeft.x() +
                _size.x() * static_cast<float>(i + kValues - _values.size()) / (kValues - 1),
            _lowerLeft.y() + _size.y() * static_cast<float>(_values[i] / most),
            0.0F));
    vertices.dirty();
    auto& strip = static_cast<osg::DrawArrays&>(*_curve->getPrimitiveSet(0));
    strip.setCount(static_cast<GLsizei>(vertices.size()));
    strip.dirty();
    _last->setText(withUnit(_values.back(), _unit), osgText::String::ENCODING_UTF8);
    _most->setText("max " + withUnit(most, _unit), osgText::String::ENCODING_UTF8);
}

} // namespace osgMidair::flat
