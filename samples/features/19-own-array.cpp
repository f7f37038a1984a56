// A custom array: two boards facing each other, with one dead transducer, which the solver leaves
// out.

#include "Frames.h"

#include <osgMidair/ArrayDescription>
#include <osgMidair/HapticSurface>

#include <osg/Shape>
#include <osg/ShapeDrawable>

#include <algorithm>

int main(int argc, char** argv)
{
    osgMidair::ArrayDescription array;
    array.name = "desk";
    // 10 x 10 transducers of 10.5 mm, 300 mm apart: centre, direction of sound, columns, ..
    array.addGrid(osg::Vec3d(0, 0, -0.15), osg::Z_AXIS, osg::X_AXIS, 10, 10, 0.0105);
    array.addGrid(osg::Vec3d(0, 0, 0.15), -osg::Z_AXIS, osg::X_AXIS, 10, 10, 0.0105);
    array.dead = {42};

    std::string error;
    const std::string file = argc > 1 ? argv[1] : "desk.json";
    if (!array.isValid(error) || !array.save(file, error)) // a file for "array" of scenes and tools
    {
        std::fprintf(stderr, "%s\n", error.c_str());
        return 1;
    }

    const osg::ref_ptr<osgMidair::HapticSurface> box =
        new osgMidair::HapticSurface(new osg::ShapeDrawable(new osg::Box(osg::Vec3(), 0.03F)));
    box->setSampling(osgMidair::HapticProperty::VERTICES);
    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->setArrayDescription(array);
    scene->addChild(box);

    const osg::ref_ptr<const osgMidair::HapticField> field = Frames(*scene).untilPlayed();
    if (!field) return 1;
    const std::vector<std::complex<float>> q = field->getActivations();
    const auto on =
        std::count_if(q.begin(), q.end(), [](std::complex<float> a) { return a != 0.F; });
    std::printf("%ld of %zu transducers play %zu points\n",
                static_cast<long>(on),
                q.size(),
                field->getPoints().size());
    const osgMidair::HapticField::ControlPoint& point = field->getPoints().front();
    for (int mm = 0; mm <= 6; mm += 2)
        std::printf("%d mm beside a point: %.0f Pa\n",
                    mm,
                    std::abs(field->getPressure(point.position + osg::X_AXIS * (1e-3 * mm))));
    return on == 199 ? 0 : 1;
}
