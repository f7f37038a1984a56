// Size and pressure: scales a model of unknown units to 80 mm and asks for 300 Pa. A cap of the
// scene limits all objects below it.

#include "Frames.h"

#include <osgMidair/HapticSurface>

#include <osg/MatrixTransform>
#include <osgDB/ReadFile>

#include <algorithm>

int main(int argc, char** argv)
{
    const osg::ref_ptr<osg::Node> model = osgDB::readRefNodeFile(argc > 1 ? argv[1] : "star.obj");
    if (!model) return 1;

    const osg::ref_ptr<osgMidair::HapticSurface> surface = new osgMidair::HapticSurface(model);
    surface->setPressureUnit(osgMidair::HapticProperty::PASCAL); // the default unit is relative
    surface->setPressure(300.0);                                 // peak, at the control points
    surface->setSpacing(0.010); // m between control points; default: a wavelength, 8.6 mm

    // Sizes are in metres, whatever the model's units: this centres it and makes it 80 mm wide.
    const osg::BoundingSphere bound = model->getBound();
    const osg::ref_ptr<osg::MatrixTransform> size =
        new osg::MatrixTransform(osg::Matrix::translate(-bound.center()) *
                                 osg::Matrix::scale(osg::Vec3(1, 1, 1) * 0.04F / bound.radius()));
    size->addChild(surface);

    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->setMaxPressure(800.0); // limit for all points of this scene
    scene->addChild(size);

    const osg::ref_ptr<const osgMidair::HapticField> field = Frames(*scene).untilPlayed();
    if (!field) return 1;
    double least_Pa = 1e9;
    double most_Pa = 0.0;
    for (const osgMidair::HapticField::ControlPoint& point : field->getPoints())
    {
        least_Pa = std::min(least_Pa, point.achieved_Pa);
        most_Pa = std::max(most_Pa, point.achieved_Pa);
    }
    std::printf("%zu points, wanted 300 Pa, played %.0f to %.0f Pa\n",
                field->getPoints().size(),
                least_Pa,
                most_Pa);
    return 0;
}
