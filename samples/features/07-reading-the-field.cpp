// Reading the field: the pressure along a line, and a slice as a picture, without OpenGL. A field
// is immutable: it may be read on any thread while newer ones are solved.

#include "Frames.h"

#include <osgMidair/FieldPicture>
#include <osgMidair/HapticPoints>

#include <osgDB/WriteFile>

#include <complex>

int main(int argc, char** argv)
{
    const osg::ref_ptr<osgMidair::HapticPoints> points = new osgMidair::HapticPoints;
    points->setPoints({{-0.015, 0.0, 0.0}, {0.015, 0.0, 0.0}});
    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->addChild(points);

    const osg::ref_ptr<const osgMidair::HapticField> field = Frames(*scene).untilPlayed();
    if (!field) return 1;

    for (int mm = -15; mm <= 15; mm += 5)
        std::printf("x = %+3d mm: %5.0f Pa\n",
                    mm,
                    std::abs(field->getPressure(osg::Vec3d(1e-3 * mm, 0.0, 0.0))));

    osgMidair::FieldPicture picture; // 80 x 60 mm, in the points' plane
    picture.corner = osg::Vec3d(-0.04, 0.0, -0.03);
    picture.across = osg::Vec3d(0.08, 0.0, 0.0);
    picture.up = osg::Vec3d(0.0, 0.0, 0.06);
    picture.columns = 161;
    picture.rows = 121;
    picture.pressures_Pa = field->getFeltPressures(picture.getPlaces());
    for (const osgMidair::HapticField::ControlPoint& point : field->getPoints())
        picture.points.push_back({point.position, point.wanted_Pa, point.achieved_Pa});
    const osg::ref_ptr<osg::Image> image = picture.createSlice();
    if (!image || !osgDB::writeImageFile(*image, argc > 1 ? argv[1] : "slice.png")) return 1;
    std::printf("a slice of %d x %d pixels\n", image->s(), image->t());
    return 0;
}
