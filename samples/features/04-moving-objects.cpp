// Moving objects: an animation moves a ball to and fro, and it is felt where it is seen, without
// further code. Fields are solved on another thread, so frames never wait.

#include "Frames.h"

#include <osgMidair/HapticSurface>

#include <osg/AnimationPath>
#include <osg/MatrixTransform>
#include <osg/Shape>
#include <osg/ShapeDrawable>

int main()
{
    const osg::ref_ptr<osgMidair::HapticSurface> ball =
        new osgMidair::HapticSurface(new osg::ShapeDrawable(new osg::Sphere(osg::Vec3(), 0.015F)));

    const osg::ref_ptr<osg::AnimationPath> path = new osg::AnimationPath;
    path->setLoopMode(osg::AnimationPath::SWING);
    path->insert(0.0, osg::AnimationPath::ControlPoint(osg::Vec3d(-0.04, 0.0, 0.0)));
    path->insert(1.0, osg::AnimationPath::ControlPoint(osg::Vec3d(0.04, 0.0, 0.0)));
    const osg::ref_ptr<osg::MatrixTransform> carried = new osg::MatrixTransform;
    carried->setUpdateCallback(new osg::AnimationPathCallback(path));
    carried->addChild(ball);

    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->addChild(carried);

    Frames frames(*scene);
    if (!frames.untilPlayed()) return 1;
    for (int i = 0; i < 4; ++i)
    {
        frames.run(0.4);
        const osg::ref_ptr<const osgMidair::HapticField> field = scene->getField();
        if (field->getPoints().empty()) return 1;
        osg::Vec3d middle;
        for (const osgMidair::HapticField::ControlPoint& point : field->getPoints())
            middle += point.position / static_cast<double>(field->getPoints().size());
        std::printf("%.2f s: %zu points round x = %+.0f mm\n",
                    field->getSimulationTime(),
                    field->getPoints().size(),
                    1e3 * middle.x());
    }
    const osgMidair::HapticStatistics so_far = scene->getStatistics();
    std::printf("moved: %s\n", so_far.solves > 10 ? "a field for nearly each frame" : "too few");
    return so_far.solves > 10 ? 0 : 1;
}
