#include "plugin/overlays/OverlayPart.h"
#include "plugin/overlays/drawing/DiscGeometry.h"
#include "plugin/overlays/drawing/PixelDrawing.h"

#include <osgMidair/WorkspaceBox>

#include <osg/Geometry>
#include <osgGA/GUIEventAdapter>

#include <cmath>
#include <string>

namespace osgMidair
{

namespace
{

const OverlayRegistration kWorkspaceBoxRegistration({4,
                                                     "Workspace",
                                                     "workspace",
                                                     "the workspace",
                                                     "the workspace as a box with its axes, in mm",
                                                     osgGA::GUIEventAdapter::KEY_F5,
                                                     20,
                                                     makeOverlay<WorkspaceBox>});

const osg::Vec4 kLine(0.62F, 0.68F, 0.76F, 0.55F);
const osg::Vec4 kWorkspaceInk(0.78F, 0.82F, 0.88F, 0.9F);

} // namespace

WorkspaceBox::WorkspaceBox() : Overlay(std::make_unique<OverlayPart>())
{
    setBox(osg::BoundingBox(-0.1F, -0.1F, -0.1F, 0.1F, 0.1F, 0.1F));
    drawTranslucent(*this, BOX_BIN);
}

WorkspaceBox::~WorkspaceBox() = default;

void WorkspaceBox::setBox(const osg::BoundingBox& box_m)
{
    if (box_m == _box && getNumChildren() > 0) return;
    _box = box_m;
    removeChildren(0, getNumChildren());
    osg::ref_ptr<osg::Vec3Array> lines = new osg::Vec3Array;
    for (unsigned int corner = 0; corner < 8; ++corner)
        for (unsigned int axis = 1; axis < 8; axis <<= 1)
            if (!(corner & axis))
            {
                lines->push_back(_box.corner(corner));
                lines->push_back(_box.corner(corner | axis));
            }
    // Ticks along three edges in front, with numbers only at the ends, where there is room. z is on
    // the right, as the figures are on the left.
    const float textSize = 0.055F * 2.0F * _box.radius() / std::sqrt(3.0F);
    for (int axis = 0; axis < 3; ++axis)
    {
        const float side = axis == 2 ? 1.0F : -1.0F;
        osg::Vec3 outward(side, -1.0F, -1.0F);
        outward[axis] = 0.0F;
        outward.normalize();
        for (const double tick : pixels::ticks(1e3 * _box._min[axis], 1e3 * _box._max[axis], 5))
        {
            osg::Vec3 at(axis == 2 ? _box.xMax() : _box.xMin(), _box.yMin(), _box.zMin());
            at[axis] = static_cast<float>(1e-3 * tick);
            lines->push_back(at);
            lines->push_back(at + outward * (0.3F * textSize));
        }
        osg::Vec3 end(axis == 2 ? _box.xMax() : _box.xMin(), _box.yMin(), _box.zMin());
        end[axis] = _box._max[axis];
        osg::Vec3 beyond = outward * 0.9F;
        beyond[axis] = 0.6F;
        addChild(pixels::axisLabel(std::string(1, "xyz"[axis]) + " = " +
                                       pixels::number(std::round(1e3 * _box._max[axis])) + " mm",
                                   end + beyond * textSize,
                                   textSize,
                                   kWorkspaceInk));
    }
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    geometry->setVertexArray(lines);
    geometry->setColorArray(new osg::Vec4Array(1, &kLine), osg::Array::BIND_OVERALL);
    geometry->addPrimitiveSet(
        new osg::DrawArrays(GL_LINES, 0, static_cast<GLsizei>(lines->size())));
    addChild(geometry);
}

} // namespace osgMidair
