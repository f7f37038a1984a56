#include "samples/shared/views/PictureTaker.h"

#include <osgMidair/Hud>

namespace midair::samples
{

PictureTaker::PictureTaker(osg::Node& scene,
                           osgMidair::HapticOverlays& overlays,
                           int width,
                           int height,
                           double fovy_deg,
                           const std::function<void(osg::Camera&)>& aim,
                           std::string& problem) :
    _overlays(&overlays),
    _grabber(new FrameGrabber(kScale))
{
    _viewer.setLightingMode(osg::View::NO_LIGHT);
    _ready = setUpOffscreen(_viewer, width * kScale, height * kScale, fovy_deg, &problem);
    if (!_ready) return;
    aim(*_viewer.getCamera());
    _viewer.getCamera()->setFinalDrawCallback(_grabber);
    _viewer.setSceneData(&scene);
}

osg::ref_ptr<osg::Image> PictureTaker::take()
{
    if (!_ready) return nullptr;
    osgMidair::Hud& figures = *_overlays->get<osgMidair::Hud>();
    const float scale = figures.getScale();
    const osg::Viewport& viewport = *_viewer.getCamera()->getViewport();
    const float own =
        osgMidair::Hud::scaleFor(viewport.width() / kScale, viewport.height() / kScale);
    figures.setScale(kScale * (scale > 0.0F ? scale : own));
    _viewer.renderingTraversals(); // compiles new GL objects
    _grabber->request();
    _viewer.renderingTraversals();
    figures.setScale(scale);
    return _grabber->image();
}

} // namespace midair::samples
