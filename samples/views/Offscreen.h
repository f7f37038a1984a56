#pragma once

#include <osg/GraphicsContext>
#include <osg/Image>
#include <osg/Node>
#include <osgViewer/Viewer>

#include <string>

namespace midair::samples
{

/// True where a window can be opened (an X display is named).
bool haveDisplay();

/// An OpenGL context of \a width x \a height pixels that needs no display, no window system and no
/// graphics card (surfaceless EGL; software rendering where there is nothing better). Null when
/// there is none; \a error says why.
osg::ref_ptr<osg::GraphicsContext>
createOffscreenContext(int width, int height, std::string* error);

/// Makes \a viewer draw into an off-screen context of that size, single-threaded, with a
/// perspective of \a fovy_deg. False, with \a error, where there is no OpenGL to be had.
bool setUpOffscreen(
    osgViewer::Viewer& viewer, int width, int height, double fovy_deg, std::string* error);

/// Draws \a scene once in pixel coordinates (origin bottom left) over \a background and gives the
/// picture, RGB. Null with \a error.
osg::ref_ptr<osg::Image> renderFlat(
    osg::Node& scene, int width, int height, const osg::Vec4& background, std::string* error);

/// Keeps the picture of the next frame that is drawn after request().
class FrameGrabber : public osg::Camera::DrawCallback
{
public:
    /// \a scale: the context is that many times larger than the picture, which is averaged down
    /// (smooth edges and text).
    explicit FrameGrabber(int scale = 1);

    void request() const { _wanted = true; }
    /// The last picture, or null.
    osg::ref_ptr<osg::Image> image() const { return _image; }

    void operator()(osg::RenderInfo& renderInfo) const override;

private:
    int _scale = 1;
    mutable bool _wanted = false;
    mutable osg::ref_ptr<osg::Image> _image;
};

/// \a image (RGB, 8 bit) averaged over squares of \a scale x \a scale pixels.
osg::ref_ptr<osg::Image> averagedDown(const osg::Image& image, int scale);

} // namespace midair::samples
