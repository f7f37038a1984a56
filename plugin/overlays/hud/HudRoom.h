#pragma once

#include <osg/Matrixd>
#include <osg/Referenced>
#include <osg/Vec2>

namespace osg
{
class Camera;
}

namespace osgUtil
{
class CullVisitor;
}

namespace osgMidair
{

/// The part of a viewport available for figures, in units of \a scale pixels, with the origin in
/// the viewport's lower left corner.
struct HudRoom
{
    double scale = 1.0;  ///< pixels per unit
    osg::Vec2 viewport;  ///< size of the viewport
    float top = 0.0F;    ///< height left to the program's own signs at the top
    osg::Vec2 lowerLeft; ///< of the room
    osg::Vec2 upperRight;

    float width() const { return upperRight.x() - lowerLeft.x(); }
    float height() const { return upperRight.y() - lowerLeft.y(); }
    /// Area that figures share with the scene.
    float area() const { return viewport.x() * (viewport.y() - top); }
};

/// A sheet in the world on which figures are drawn instead of in the viewport: in a headset,
/// figures at one place of both viewports would be seen double. It is user data of the eyes'
/// cameras.
struct WorldSheet : public osg::Referenced
{
    osg::Matrixd toWorld;           ///< from its units
    osg::Vec2 size{640.0F, 480.0F}; ///< in units: letters are over a degree high

    /// Null: figures are in the viewport.
    static const WorldSheet* of(const osg::Camera* camera);
};

/// Returns the pixels per unit for readable figures in a viewport of that size: 1 up to 1050 pixels
/// of height and 1400 of width, and 0.5 more for each further 350 and 467.
double hudScale(double width, double height);

/// Returns the pixels per unit for labels in a scene, which are read from farther away than
/// figures: 1 up to 560 pixels of height and 747 of width, and in proportion above.
double labelScale(double width, double height);

/// Returns the room for figures in the viewport of \a visitor: all of it, without the fraction \a
/// top of its height at the top, and without the area that osgViewer's statistics (the `s` key)
/// cover now. \a scale: pixels per unit; 0: hudScale(). From any cull thread.
HudRoom roomOf(osgUtil::CullVisitor& visitor, double scale, float top = 0.0F);

} // namespace osgMidair
