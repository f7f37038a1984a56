#pragma once

#include <osg/GraphicsContext>
#include <osg/Image>
#include <osg/Node>
#include <osgViewer/Viewer>

#include <string>

namespace midair::samples
{

/// Returns true if a window can be opened (DISPLAY is set).
bool haveDisplay();

/// Creates an OpenGL context of \a width x \a height pixels without a display, window system or
/// graphics card (surfaceless EGL; software rendering without a GPU). Returns null and sets
/// \a error on failure.
osg::ref_ptr<osg::GraphicsContext>
createOffscreenContext(int width, int height, std::string* error);

/// Makes \a viewer draw into an off-screen context of that size, single-threaded, with a vertical
/// field of view of \a fovy_deg. Returns false and sets \a error if there is no OpenGL.
bool setUpOffscreen(
    osgViewer::Viewer& viewer, int width, int height, double fovy_deg, std::string* error);

/// Draws \a scene once in pixel coordinates (origin bottom left) over \a background and returns the
/// RGB picture. Returns null and sets \a error on failure.
osg::ref_ptr<osg::Image> renderFlat(
    osg::Node& scene, int width, int height, const osg::Vec4& background, std::string* error);

/// Draw callback that keeps the first picture drawn after request().
class FrameGrabber : public osg::Camera::DrawCallback
{
public:
    /// \a scale is the ratio of the context's size to the picture's; the picture is averaged down
    /// for smooth edges and text.
    explicit FrameGrabber(int scale = 1);

    void request() const { _wanted = true; }
    /// Returns the last picture, or null.
    osg::ref_ptr<osg::Image> image() const { return _image; }

    void operator()(osg::RenderInfo& renderInfo) const override;

private:
    int _scale = 1;
    mutable bool _wanted = false;
    mutable osg::ref_ptr<osg::Image> _image;
};

/// Returns \a image (RGB, 8 bit) averaged over squares of \a scale x \a scale pixels.
osg::ref_ptr<osg::Image> averagedDown(const osg::Image& image, int scale);

} // namespace midair::samples
