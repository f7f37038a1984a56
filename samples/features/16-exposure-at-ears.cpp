// Exposure: the ultrasound level at places where ears may be, and a limit for every field. It is
// not a safety certificate; samples/guides/SAFETY.md explains the numbers.

#include "Frames.h"

#include <osgMidair/HapticSurface>

#include <osg/Shape>
#include <osg/ShapeDrawable>

int main()
{
    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->addChild(
        new osgMidair::HapticSurface(new osg::ShapeDrawable(new osg::Sphere(osg::Vec3(), 0.02F))));
    // A visitor's ears, m in the array's frame, in addition to places around the array.
    scene->setEarPoints("-0.08 0.5 0.3; 0.08 0.5 0.3");

    Frames frames(*scene);
    if (!frames.untilPlayed()) return 1;
    frames.run(0.5);
    const osgMidair::HapticStatistics loud = scene->getStatistics();
    std::printf(
        "%d places: %.0f dB at the loudest, %.0f dB of it for a head; %.0f Pa on the ball\n",
        loud.exposure.places,
        loud.exposure.level_dB,
        loud.exposure.head_dB,
        loud.level_Pa);

    // Limits for workers and for the public, rms re 20 uPa. A user sets OSG_MIDAIR_EAR_LIMIT.
    for (const double limit_dB : {110.0, 100.0})
    {
        scene->setEarLimit(limit_dB);
        frames.run(1.0);
        const osgMidair::HapticStatistics held = scene->getStatistics();
        std::printf("held to %.0f dB: %.0f dB, %.1f Pa, %.2g %% of it\n",
                    held.exposure.limit_dB,
                    held.exposure.level_dB,
                    held.level_Pa,
                    100.0 * held.level_Pa / loud.level_Pa);
        for (const osgMidair::HapticMessage& message : held.told)
            if (message.code.rfind("ears", 0) == 0 || message.code.rfind("cap", 0) == 0)
                std::printf("%s: %s\n", message.code.c_str(), message.text.c_str());
        if (held.exposure.level_dB > limit_dB + 0.01) return 1;
    }
    return 0;
}
