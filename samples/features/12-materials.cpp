// Materials: how a surface feels when touched. Prints the range of contact pressures over half a
// second for a finger that is 0.3 mm deep in a ball of each material.

#include "Frames.h"

#include <osgMidair/HapticSurface>

#include <osg/Shape>
#include <osg/ShapeDrawable>

#include <algorithm>

int main()
{
    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->setRender(osgMidair::HapticSettings::CONTACT);
    const osg::ref_ptr<osgMidair::HapticSurface> ball =
        new osgMidair::HapticSurface(new osg::ShapeDrawable(new osg::Sphere(osg::Vec3(), 0.03F)));
    scene->addChild(ball);
    const osg::ref_ptr<osgMidair::InjectedHands> hands = new osgMidair::InjectedHands;
    scene->setHandSource(hands);
    const auto touch = [&hands](double /*time_s*/)
    {
        hands->setHands({osgMidair::openHand(
            1, osg::Vec3d(0.0, 0.0, 0.0367), osg::Quat(-osg::PI / 3.0, osg::Vec3d(1, 0, 0)))});
    };

    Frames frames(*scene);
    for (const char* const material : {"rubber", "glass", "sandpaper", "cloth"})
    {
        ball->setMaterial(material); // may change during a touch
        frames.run(0.3, touch);
        double least_Pa = 1e9;
        double most_Pa = 0.0;
        const auto look = [&](double time_s)
        {
            touch(time_s);
            const osg::ref_ptr<const osgMidair::HapticField> field = scene->getField();
            if (!field || field->getPoints().empty()) return;
            least_Pa = std::min(least_Pa, field->getPoints().front().wanted_Pa);
            most_Pa = std::max(most_Pa, field->getPoints().front().wanted_Pa);
        };
        frames.run(0.5, look);
        std::printf("%-9s %.0f to %.0f Pa\n", material, least_Pa, most_Pa);
        if (most_Pa == 0.0) return 1;
    }
    // Override a number of the material.
    ball->setMaterial("glass");
    ball->setContactForce(0.005); // N
    frames.run(0.5, touch);
    std::printf("glass of at most 5 mN: %.0f Pa\n",
                scene->getField()->getPoints().front().wanted_Pa);
    return 0;
}
