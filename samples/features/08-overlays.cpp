// Overlays: one node anywhere below the scene draws points, slice, array and figures, and handles
// the keys F1 to F12.

#include <osgMidair/FieldSliceOverlay>
#include <osgMidair/HapticOverlays>
#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>
#include <osgMidair/Hud>

#include <osg/Shape>
#include <osg/ShapeDrawable>
#include <osgViewer/Viewer>

#include <cstdio>

int main()
{
    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->addChild(
        new osgMidair::HapticSurface(new osg::ShapeDrawable(new osg::Sphere(osg::Vec3(), 0.02F))));

    const osg::ref_ptr<osgMidair::HapticOverlays> overlays = new osgMidair::HapticOverlays;
    overlays->setShown("volume", false);
    overlays->setShown("workspace", false);
    overlays->get<osgMidair::Hud>()->setTitle("a ball of 40 mm");
    osgMidair::FieldSliceOverlay& slice = *overlays->get<osgMidair::FieldSliceOverlay>();
    slice.setPlane(osg::Vec3d(), osg::Y_AXIS);               // default: through the points
    if (!overlays->setNumber("sliceRadius", 0.06)) return 1; // m
    scene->addChild(overlays);
    for (const osgMidair::OverlayDescription& each : osgMidair::HapticOverlays::describe())
        std::printf("%-3s %s%s\n",
                    each.key.c_str(),
                    each.help.c_str(),
                    overlays->isShown(each.name) ? "" : " (hidden)");

    osgViewer::Viewer viewer;
    viewer.setSceneData(scene);
    const int ended = viewer.run();
    std::printf("%d points were shown\n", scene->getStatistics().points);
    return ended;
}
