// Control points without a surface, each with its own pressure, and lines of a geometry, which are
// felt along their length.

#include "Frames.h"

#include <osgMidair/HapticPoints>
#include <osgMidair/HapticSurface>

#include <osg/Geometry>

int main()
{
    const osg::ref_ptr<osgMidair::HapticPoints> points = new osgMidair::HapticPoints;
    points->setName("points");
    points->setPressureUnit(osgMidair::HapticProperty::PASCAL);
    points->setPoints({{0.0, 0.0, 0.0}, {0.02, 0.0, 0.0}}, {800.0, 400.0}); // m; Pa for each

    const osg::ref_ptr<osg::Vec3Array> ends = new osg::Vec3Array;
    ends->push_back(osg::Vec3(-0.03F, 0.0F, 0.02F));
    ends->push_back(osg::Vec3(0.03F, 0.0F, 0.02F));
    const osg::ref_ptr<osg::Geometry> lines = new osg::Geometry;
    lines->setVertexArray(ends);
    lines->addPrimitiveSet(new osg::DrawArrays(GL_LINES, 0, 2));
    const osg::ref_ptr<osgMidair::HapticSurface> line = new osgMidair::HapticSurface(lines);
    line->setName("line");
    line->setPressureUnit(osgMidair::HapticProperty::PASCAL);
    line->setPressure(300.0);

    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->addChild(points);
    scene->addChild(line);

    const osg::ref_ptr<const osgMidair::HapticField> field = Frames(*scene).untilPlayed();
    if (!field) return 1;
    for (const osgMidair::HapticField::ControlPoint& point : field->getPoints())
        std::printf("%s at x = %+.0f mm, z = %+.0f mm: %.0f Pa wanted, %.0f Pa played\n",
                    field->getObjects()[point.object].path.c_str(),
                    1e3 * point.position.x(),
                    1e3 * point.position.z(),
                    point.wanted_Pa,
                    point.achieved_Pa);
    return 0;
}
