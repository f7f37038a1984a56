// Contact mode: instead of the whole object, a few foci circle on the skin where a hand touches it.
// That presses far stronger. Without a touch the array is silent.

#include "Frames.h"

#include <osgMidair/HapticSurface>

#include <osg/Shape>
#include <osg/ShapeDrawable>

#include <algorithm>

namespace
{

double strongest_Pa(const osgMidair::HapticScene& scene)
{
    const osg::ref_ptr<const osgMidair::HapticField> field = scene.getField();
    double most_Pa = 0.0;
    if (field)
        for (const osgMidair::HapticField::ControlPoint& point : field->getPoints())
            most_Pa = std::max(most_Pa, point.achieved_Pa);
    return most_Pa;
}

} // namespace

int main()
{
    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->addChild(
        new osgMidair::HapticSurface(new osg::ShapeDrawable(new osg::Sphere(osg::Vec3(), 0.03F))));
    const osg::ref_ptr<osgMidair::InjectedHands> hands = new osgMidair::InjectedHands;
    scene->setHandSource(hands);
    // The index fingertip, 7 mm in radius, is 2 mm deep in the ball.
    const auto touch = [&hands](double /*time_s*/)
    {
        hands->setHands({osgMidair::openHand(
            1, osg::Vec3d(0.0, 0.0, 0.035), osg::Quat(-osg::PI / 3.0, osg::Vec3d(1, 0, 0)))});
    };

    Frames frames(*scene);
    if (!frames.untilPlayed(touch)) return 1;
    const double whole_Pa = strongest_Pa(*scene);
    std::printf("the whole ball: %d points, %.0f Pa\n", scene->getStatistics().points, whole_Pa);

    scene->setRender(osgMidair::HapticSettings::CONTACT); // AUTO: only while hands are tracked well
    frames.run(1.0, touch);
    const double contact_Pa = strongest_Pa(*scene);
    std::printf(
        "where it is touched: %d foci, %.0f Pa\n", scene->getStatistics().points, contact_Pa);

    hands->setHands({});
    frames.run(0.5);
    std::printf("untouched: %s\n", stateName(scene->getStatistics().state));
    return contact_Pa > whole_Pa ? 0 : 1;
}
