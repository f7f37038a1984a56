// Hands: the application sets one, as its tracker gives it, and all power goes to what is near it.
// With a recording as argument that is played instead; "mouse:", "osc:" and "openxr:" are others.

#include "Frames.h"

#include <osgMidair/HapticSurface>

#include <osg/Shape>
#include <osg/ShapeDrawable>

int main(int argc, char** argv)
{
    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->addChild(
        new osgMidair::HapticSurface(new osg::ShapeDrawable(new osg::Box(osg::Vec3(), 0.06F))));
    scene->setReach(0.015);  // m: only points this near to a hand are solved for
    scene->setShadows(true); // the hand blocks sound, which the solver takes into account

    const osg::ref_ptr<osgMidair::InjectedHands> hands = new osgMidair::InjectedHands;
    if (argc > 1)
        scene->setHands(std::string("recorded:") + argv[1] + "?loop");
    else
        scene->setHandSource(hands);

    // A right hand with stretched fingers, tilted down, its index finger on top of the box.
    const auto hold = [&hands](double /*time_s*/)
    {
        hands->setHands({osgMidair::openHand(
            1, osg::Vec3d(0.0, 0.0, 0.036), osg::Quat(-osg::PI / 6.0, osg::Vec3d(1, 0, 0)))});
    };
    Frames frames(*scene);
    if (!frames.untilPlayed(hold)) return 1;
    frames.run(0.5, hold);
    const osgMidair::HapticStatistics now = scene->getStatistics();
    std::printf("%d hand: %d points near it are solved for, %.0f Pa, %s\n",
                now.hands,
                now.points,
                now.level_Pa,
                now.outOfReach > 0 ? "others are left out" : "all of them");

    hands->setHands({});
    frames.run(0.5);
    std::printf("without a hand: %s\n", stateName(scene->getStatistics().state));
    return 0;
}
