// Hands: the application sets a hand, as from its own tracker, and all power goes to the points
// near it. With an argument it plays that recording instead. Other sources: "mouse:", "osc:",
// "openxr:".

#include "Frames.h"

#include <osgMidair/HapticSurface>

#include <osg/Shape>
#include <osg/ShapeDrawable>

int main(int argc, char** argv)
{
    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->addChild(
        new osgMidair::HapticSurface(new osg::ShapeDrawable(new osg::Box(osg::Vec3(), 0.06F))));
    scene->setReach(0.015);  // m; solves only for points this close to a hand
    scene->setShadows(true); // the solver takes into account that the hand blocks sound

    const osg::ref_ptr<osgMidair::InjectedHands> hands = new osgMidair::InjectedHands;
    if (argc > 1)
        scene->setHands(std::string("recorded:") + argv[1] + "?loop");
    else
        scene->setHandSource(hands);

    // A right hand with stretched fingers, tilted down, with its index finger on top of the box.
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
