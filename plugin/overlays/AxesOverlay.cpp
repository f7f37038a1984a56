#include "plugin/overlays/OverlayPart.h"
#include "plugin/overlays/drawing/DiscGeometry.h"
#include "plugin/overlays/drawing/PixelDrawing.h"

#include <osgMidair/AxesOverlay>

#include <osg/Geometry>
#include <osg/LineWidth>

#include <string>

namespace osgMidair
{

namespace
{

const OverlayNumber kAxesLength =
    overlayNumber<AxesOverlay, &AxesOverlay::setLength, &AxesOverlay::getLength>(
        "axesLength", "length of the array's axes", {0.001, 1.0}, "m");
const OverlayRegistration
    kAxesRegistration({10,
                       "Axes",
                       "axes",
                       "the axes of the array's frame",
                       "the axes of the array's frame from its origin, x red, y green, z blue",
                       0,
                       25,
                       makeOverlay<AxesOverlay>,
                       {kAxesLength},
                       true});

constexpr double kInitialLength_m = 0.05;
constexpr float kAxisWidth = 2.5F;
const osg::Vec4 kAxisColors[] = {
    {0.95F, 0.32F, 0.30F, 1.0F}, {0.40F, 0.82F, 0.36F, 1.0F}, {0.38F, 0.58F, 1.00F, 1.0F}};

} // namespace

AxesOverlay::AxesOverlay() : Overlay(std::make_unique<OverlayPart>())
{
    osg::StateSet* state = getOrCreateStateSet();
    state->setAttributeAndModes(new osg::LineWidth(kAxisWidth));
    drawTranslucent(*this, BOX_BIN);
    state->setMode(GL_DEPTH_TEST, osg::StateAttribute::OFF | osg::StateAttribute::PROTECTED);
    setLength(kInitialLength_m);
}

AxesOverlay::~AxesOverlay() = default;

void AxesOverlay::setLength(double length_m)
{
    if (length_m == _length_m) return;
    _length_m = length_m;
    removeChildren(0, getNumChildren());
    const auto length = static_cast<float>(length_m);
    osg::ref_ptr<osg::Vec3Array> ends = new osg::Vec3Array;
    osg::ref_ptr<osg::Vec4Array> colors = new osg::Vec4Array;
    for (unsigned int axis = 0; axis < 3; ++axis)
    {
        osg::Vec3 end;
        end[axis] = length;
        for (const osg::Vec3& one : {osg::Vec3(), end})
        {
            ends->push_back(one);
            colors->push_back(kAxisColors[axis]);
        }
        addChild(pixels::axisLabel(
            std::string(1, "xyz"[axis]), end * 1.15F, 0.2F * length, kAxisColors[axis]));
    }
    osg::ref_ptr<osg::Geometry> lines = new osg::Geometry;
    lines->setVertexArray(ends);
    lines->setColorArray(colors, osg::Array::BIND_PER_VERTEX);
    lines->addPrimitiveSet(new osg::DrawArrays(GL_LINES, 0, 6));
    addChild(lines);
}

} // namespace osgMidair
