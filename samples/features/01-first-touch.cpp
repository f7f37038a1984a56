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
    scene->addChild(touchable); // at any depth, also below transforms, switches and levels of
                                // detail

    osgViewer::Viewer viewer;
    viewer.setSceneData(scene);
    viewer.run(); // from now on it can be felt where it is seen
    std::cout << scene->getStatistics().points << " points were felt\n";
}
