// Prediction: sound takes a millisecond, a solve some more, a tracker tens of milliseconds. A
// filter predicts where a moving hand will be then.

#include "Frames.h"

#include <osgMidair/HapticSurface>

#include <osg/Shape>
#include <osg/ShapeDrawable>

#include <cmath>

int main()
{
    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    const osg::ref_ptr<osgMidair::HapticSurface> plate = new osgMidair::HapticSurface(
        new osg::ShapeDrawable(new osg::Box(osg::Vec3(), 0.12F, 0.04F, 0.01F)));
    plate->setTouchEvents(true);
    scene->addChild(plate);
    scene->setPrediction(osgMidair::HapticSettings::KALMAN);
    scene->setTrackerDelay(0.030); // s: age of the tracker's hands when they arrive
    const osg::ref_ptr<osgMidair::InjectedHands> hands = new osgMidair::InjectedHands;
    scene->setHandSource(hands);

    // The tracker sees an index finger slide along the plate, to and fro in 1.5 s.
    double seen_m = 0.0;
    double largest_m = 0.0;
    double predicted_ms = 0.0;
    const auto slide = [&](double time_s)
    {
        // Compares the last frame's touch with the tracked position of its hand.
        for (const osgMidair::Touch& touch : scene->getTouches())
            if (touch.finger == osgMidair::Touch::INDEX)
                largest_m = std::max(largest_m, std::abs(touch.position.x() - seen_m));
        predicted_ms = std::max(predicted_ms, scene->getStatistics().predicted_ms);
        seen_m = 0.04 * std::sin(2.0 * osg::PI * time_s / 1.5);
        hands->setHands({osgMidair::openHand(
            1, osg::Vec3d(seen_m, 0.0, 0.010), osg::Quat(-osg::PI / 3.0, osg::Vec3d(1, 0, 0)))});
    };
    Frames frames(*scene);
    if (!frames.untilPlayed(slide)) return 1;
    frames.run(1.5, slide);
    std::printf("predicted by up to %.0f ms: the touch is up to %.0f mm ahead of what is seen\n",
                predicted_ms,
                1e3 * largest_m);

    scene->setPrediction(osgMidair::HapticSettings::OFF);
    frames.run(0.2, slide);
    std::printf("without: %.0f ms\n", scene->getStatistics().predicted_ms);
    return predicted_ms >= 30.0 ? 0 : 1;
}
