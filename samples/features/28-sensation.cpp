// Sensations: a focus on a path, in time, that designers draw. One circles at a place; a click
// plays on the fingertip when the program says so.

#include "Frames.h"

#include <osgMidair/HapticSensation>

#include <osg/MatrixTransform>

namespace
{

bool isPlaying(const osgMidair::HapticScene& scene)
{
    const osg::ref_ptr<const osgMidair::HapticField> field = scene.getField();
    if (!field) return false;
    for (const osgMidair::HapticField::ControlPoint& point : field->getPoints())
        if (point.achieved_Pa > 0.0) return true;
    return false;
}

} // namespace

int main()
{
    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    const osg::ref_ptr<osgMidair::HapticSensation> circle =
        new osgMidair::HapticSensation("circle?radius=20mm&frequency=70Hz");
    circle->setPressure(10000.0);
    circle->setPressureUnit(osgMidair::HapticProperty::PASCAL);
    const osg::ref_ptr<osg::MatrixTransform> place = new osg::MatrixTransform;
    place->addChild(circle);
    scene->addChild(place);

    // A click has a higher priority: the circle gives way to it for as long as it takes.
    const osg::ref_ptr<osgMidair::HapticSensation> click = new osgMidair::HapticSensation("click");
    click->setAttach("hand:index_tip");
    click->setTrigger(osgMidair::HapticProperty::PROGRAM);
    click->setPriority(1);
    scene->addChild(click);
    const osg::ref_ptr<osgMidair::InjectedHands> hands = new osgMidair::InjectedHands;
    scene->setHandSource(hands);
    const auto hold = [&hands](double /*time_s*/)
    { hands->setHands({osgMidair::openHand(1, osg::Vec3d(0.0, 0.0, 0.03), osg::Quat())}); };

    Frames frames(*scene);
    frames.run(0.3, hold);
    const bool circles = isPlaying(*scene);
    std::printf("the circle %s\n", circles ? "plays" : "is silent");

    circle->setParameter("radius", 10.0); // felt with the next frame
    click->play();
    frames.run(0.05, hold);
    const bool clicks = isPlaying(*scene);
    std::printf("the click %s\n", clicks ? "plays" : "is silent");

    circle->setEnabled(false);
    frames.run(0.5, hold);
    std::printf("afterwards: %s\n", stateName(scene->getStatistics().state));
    return circles && clicks ? 0 : 1;
}
