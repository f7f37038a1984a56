#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <osg/MatrixTransform>
#include <osgDB/ReadFile>
#include <osgViewer/Viewer>

int main(int argc, char** argv)
{
    osg::ref_ptr<osgMidair::HapticScene> scene =
        new osgMidair::HapticScene; // simulated octagonal array
    osg::ref_ptr<osgMidair::HapticSurface> touchable = new osgMidair::HapticSurface;
    touchable->addChild(osgDB::readRefNodeFile(argc > 1 ? argv[1] : "star.obj"));
    scene->addChild(touchable); // anywhere below: transforms, switches, level of detail

    osgViewer::Viewer viewer;
    viewer.setSceneData(scene);
    return viewer.run(); // felt where it is seen, from now on
}
