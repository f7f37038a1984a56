#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <osgDB/ReadFile>
#include <osgViewer/Viewer>

#include <iostream>

int main(int argc, char** argv)
{
    osg::ref_ptr<osgMidair::HapticSurface> touchable = new osgMidair::HapticSurface;
    touchable->addChild(osgDB::readRefNodeFile(argc > 1 ? argv[1] : "star.obj"));

    osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene; // octagon, simulated
    scene->addChild(touchable); // anywhere below: transforms, switches, levels of detail

    osgViewer::Viewer viewer;
    viewer.setSceneData(scene);
    viewer.run(); // felt where it is seen, from now on
    std::cout << scene->getStatistics().points << " points were felt\n";
}
