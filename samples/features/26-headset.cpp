/// A ball in a headset, felt where it is seen and touched by the hands that the headset tracks.
#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>
#include <osgMidair/HeadsetView>

#include <osg/MatrixTransform>
#include <osg/ShapeDrawable>
#include <osgViewer/Viewer>

#include <cstdio>
#include <string>

int main()
{
    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->setArray("board");
    scene->setHands("openxr:");
    scene->setHeads("openxr:");
    const osg::ref_ptr<osg::MatrixTransform> place = new osg::MatrixTransform;
    place->setMatrix(osg::Matrix::translate(0.0, 0.0, 0.15));
    place->addChild(
        new osgMidair::HapticSurface(new osg::ShapeDrawable(new osg::Sphere(osg::Vec3(), 0.02F))));
    scene->addChild(place);

    osgViewer::Viewer viewer;
    viewer.setSceneData(scene);
    viewer.setUpViewInWindow(60, 60, 800, 600);
    viewer.getCamera()->setViewMatrixAsLookAt({0.0, -0.6, 0.3}, {0.0, 0.0, 0.15}, {0.0, 0.0, 1.0});

    // Without a headset, the window shows the scene.
    std::string error;
    const auto headset = osgMidair::HeadsetView::open("openxr:", error);
    const bool isShown = headset && headset->attach(viewer, error);
    std::printf("%s\n", isShown ? headset->getStatus().c_str() : error.c_str());
    viewer.realize();
    return viewer.run(); // the headset replaces the manipulator
}
