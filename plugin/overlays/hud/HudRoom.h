#pragma once

#include <osg/Vec2>

namespace osgUtil
{
class CullVisitor;
}

namespace osgMidair
{

/// The part of a viewport that figures may be drawn in, in units of \a scale pixels, with the
/// origin in the viewport's lower left corner.
struct HudRoom
{
    double scale = 1.0;  ///< pixels per unit
    osg::Vec2 viewport;  ///< size of the viewport
    osg::Vec2 lowerLeft; ///< of the room
    osg::Vec2 upperRight;

    float width() const { return upperRight.x() - lowerLeft.x(); }
    float height() const { return upperRight.y() - lowerLeft.y(); }
};

/// Returns the pixels per unit in which figures can be read in a viewport of that size: 1 up to
/// 1050 pixels of height and 1400 of width, and 0.5 more for each further 350 and 467.
double hudScale(double width, double height);

/// Returns the room for figures in the viewport of \a visitor: all of it, but for what osgViewer's
/// statistics (the `s` key) cover there now. \a scale: pixels per unit; 0: hudScale(). From any
/// thread that culls.
HudRoom roomOf(osgUtil::CullVisitor& visitor, double scale);

} // namespace osgMidair
