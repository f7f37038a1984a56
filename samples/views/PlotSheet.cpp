#include "samples/views/PlotSheet.h"

#include "samples/views/LabelFont.h"

#include <osg/Geometry>
#include <osg/LineWidth>

#include <cmath>

namespace midair::samples
{

PlotSheet::PlotSheet() : _font(labelFont()) {}

osg::ref_ptr<osgText::Text> PlotSheet::made(const std::string& content, float size) const
{
    osg::ref_ptr<osgText::Text> text = new osgText::Text;
    text->setFont(_font);
    text->setFontResolution(40, 40);
    text->setCharacterSize(size);
    text->setText(content, osgText::String::ENCODING_UTF8);
    return text;
}

void PlotSheet::text(const std::string& content,
                     const osg::Vec2& at,
                     osgText::TextBase::AlignmentType alignment,
                     float size,
                     const osg::Vec4& color,
                     bool isUpright)
{
    const osg::ref_ptr<osgText::Text> text = made(content, size);
    text->setPosition(osg::Vec3(at, 0.0F));
    text->setColor(color);
    text->setAlignment(alignment);
    if (isUpright)
    {
        text->setAxisAlignment(osgText::TextBase::USER_DEFINED_ROTATION);
        text->setRotation(osg::Quat(osg::PI_2, osg::Z_AXIS));
    }
    _root->addChild(text);
}

float PlotSheet::widthOf(const std::string& content, float size) const
{
    const osg::BoundingBox box = made(content, size)->getBoundingBox();
    return box.valid() ? box.xMax() - box.xMin() : 0.0F;
}

void PlotSheet::add(
    const std::vector<osg::Vec2>& places, GLenum how, const osg::Vec4& color, float width, float z)
{
    const osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
    for (const osg::Vec2& place : places)
        vertices->push_back(osg::Vec3(place, z));
    const osg::ref_ptr<osg::Vec4Array> colors = new osg::Vec4Array(1, &color);
    const osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    geometry->setVertexArray(vertices);
    geometry->setColorArray(colors, osg::Array::BIND_OVERALL);
    geometry->addPrimitiveSet(new osg::DrawArrays(how, 0, static_cast<GLsizei>(vertices->size())));
    if (width > 0.0F)
        geometry->getOrCreateStateSet()->setAttributeAndModes(new osg::LineWidth(2.0F * width));
    _root->addChild(geometry);
}

void PlotSheet::line(const std::vector<osg::Vec2>& places,
                     const osg::Vec4& color,
                     float width,
                     float z)
{
    add(places, GL_LINE_STRIP, color, width, z);
}

void PlotSheet::disc(const osg::Vec2& at, float radius, const osg::Vec4& color, float z)
{
    constexpr int kCorners = 24;
    std::vector<osg::Vec2> places = {at};
    for (int k = 0; k <= kCorners; ++k)
    {
        const double angle = 2.0 * osg::PI * k / kCorners;
        places.push_back(at + osg::Vec2(radius * static_cast<float>(std::cos(angle)),
                                        radius * static_cast<float>(std::sin(angle))));
    }
    add(places, GL_TRIANGLE_FAN, color, 0.0F, z);
}

void PlotSheet::rectangle(const osg::Vec2& low,
                          const osg::Vec2& high,
                          const osg::Vec4& color,
                          float z)
{
    add({low, osg::Vec2(high.x(), low.y()), high, osg::Vec2(low.x(), high.y())},
        GL_TRIANGLE_FAN,
        color,
        0.0F,
        z);
}

} // namespace midair::samples
