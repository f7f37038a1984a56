// Statistics, messages with their codes, and the mute, which may be called from any thread.

#include "Frames.h"

#include <osgMidair/HapticSurface>

#include <osg/MatrixTransform>
#include <osg/Shape>
#include <osg/ShapeDrawable>

namespace
{

void print(const osgMidair::HapticStatistics& now)
{
    std::printf("%s: %d points, %.1f ms from frame to drive\n",
                stateName(now.state),
                now.points,
                now.latencyP50_ms);
    // A field is solved for its points; once it rests, it is spread evenly over the surface.
    if (now.evened)
        std::printf("%.0f Pa of radiation pressure on the surface, give or take %.0f %%\n",
                    now.surface.mean_Pa,
                    100.0 * now.surface.coefficientOfVariation);
    else
        std::printf("%.0f Pa at the points, error %.3f %%\n", now.level_Pa, 100.0 * now.rms);
}

} // namespace

int main()
{
    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    const osg::ref_ptr<osgMidair::HapticSurface> ball =
        new osgMidair::HapticSurface(new osg::ShapeDrawable(new osg::Sphere(osg::Vec3(), 0.02F)));
    ball->setName("ball");
    scene->addChild(ball);
    // This instance is out of the array's reach, which causes a message.
    const osg::ref_ptr<osg::MatrixTransform> far =
        new osg::MatrixTransform(osg::Matrix::translate(5.0, 0.0, 0.0));
    far->addChild(ball);
    scene->addChild(far);

    Frames frames(*scene);
    if (!frames.untilPlayed()) return 1;
    print(scene->getStatistics());
    for (int k = 0; k < 100 && !scene->getStatistics().evened; ++k)
        frames.run(0.1);
    frames.run(2.0);
    print(scene->getStatistics());
    for (const osgMidair::HapticMessage& message : scene->getActiveMessages())
        std::printf("%s (%llu x): %s\n",
                    message.code.c_str(),
                    static_cast<unsigned long long>(message.count),
                    message.text.c_str());

    scene->setMuted(true); // silent at once, even during a solve
    frames.run(0.3);
    std::printf("muted: %s\n", stateName(scene->getStatistics().state));
    scene->setMuted(false);
    frames.run(0.3);
    std::printf("and again: %s\n", stateName(scene->getStatistics().state));
    return 0;
}
