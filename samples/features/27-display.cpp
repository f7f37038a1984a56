// Co-located display: the window fills a screen whose image a half mirror shows above the array.
// The display file defines both; without an argument the one below is used.

#include <osgMidair/DisplayView>
#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <osg/MatrixTransform>
#include <osg/Shape>
#include <osg/ShapeDrawable>
#include <osgViewer/Viewer>

#include <cstdio>
#include <string>

namespace
{

// A screen that faces down, and a half mirror at 45 degrees below it. Metres, in the scene's world.
const char* const kMirror = R"({
  "screen": {"lowerLeft_m": [0.266, -0.40, 0.40], "lowerRight_m": [-0.266, -0.40, 0.40],
             "upperLeft_m": [0.266, -0.10, 0.40], "pixels": [1920, 1080]},
  "optics": [{"kind": "half-mirror", "point_m": [0, -0.25, 0.15], "normal": [0, -1, 1],
              "outline_m": [[-0.3, -0.4, 0], [0.3, -0.4, 0], [0.3, -0.1, 0.3], [-0.3, -0.1, 0.3]]}],
  "eye": "fixed 0 -0.85 0.32"
})";

} // namespace

int main(int argc, char** argv)
{
    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->setArray("board");
    const osg::ref_ptr<osg::MatrixTransform> place = new osg::MatrixTransform;
    place->setMatrix(osg::Matrix::translate(0.0, 0.0, 0.15));
    place->addChild(
        new osgMidair::HapticSurface(new osg::ShapeDrawable(new osg::Sphere(osg::Vec3(), 0.02F))));
    scene->addChild(place);

    osgViewer::Viewer viewer;
    viewer.setSceneData(scene);
    viewer.setUpViewOnSingleScreen(0);

    // The display sets view and projection in each frame and replaces a manipulator.
    std::string error;
    const auto display = osgMidair::DisplayView::open(argc > 1 ? argv[1] : kMirror, error);
    if (!display || !display->attach(viewer, error))
    {
        std::fprintf(stderr, "%s\n", error.c_str());
        return 1;
    }
    const osg::BoundingBoxd workspace(-0.05, -0.05, 0.1, 0.05, 0.05, 0.2);
    std::printf("%s; %.0f %% of the workspace is seen\n",
                display->getStatus().c_str(),
                100.0 * display->getVisibleShare(workspace));
    viewer.realize();
    const int ended = viewer.run();
    for (const std::string& message : display->getMessages())
        std::printf("%s\n", message.c_str());
    return ended;
}
