#pragma once

#include "samples/shared/views/Offscreen.h"

#include <osgMidair/HapticOverlays>

#include <functional>
#include <string>

namespace midair::samples
{

/// Takes still pictures of a scene that another viewer runs, at twice the size and averaged down.
class PictureTaker
{
public:
    /// \a aim sets view, projection and background of the camera. \a problem gets the reason if
    /// there is no OpenGL; take() then returns null.
    PictureTaker(osg::Node& scene,
                 osgMidair::HapticOverlays& overlays,
                 int width,
                 int height,
                 double fovy_deg,
                 const std::function<void(osg::Camera&)>& aim,
                 std::string& problem);

    osg::ref_ptr<osg::Image> take();

private:
    static constexpr int kScale = 2;

    osg::ref_ptr<osgMidair::HapticOverlays> _overlays;
    osgViewer::Viewer _viewer;
    osg::ref_ptr<FrameGrabber> _grabber;
    bool _ready = false;
};

} // namespace midair::samples
