#include "samples/shared/views/Offscreen.h"

#include <osg/GLExtensions>

#include <cstdlib>
#include <vector>

#include <EGL/egl.h>
#include <EGL/eglext.h>

namespace midair::samples
{

namespace
{

const char* eglErrorText()
{
    switch (eglGetError())
    {
    case EGL_SUCCESS:
        return "no error";
    case EGL_NOT_INITIALIZED:
        return "EGL_NOT_INITIALIZED";
    case EGL_BAD_ALLOC:
        return "EGL_BAD_ALLOC (out of memory)";
    case EGL_BAD_MATCH:
        return "EGL_BAD_MATCH";
    default:
        return "EGL error";
    }
}

/// An osg::GraphicsContext over a surfaceless EGL display and a pbuffer.
class SurfacelessContext : public osg::GraphicsContext
{
public:
    SurfacelessContext(int width, int height)
    {
        _traits = new Traits;
        _traits->width = width;
        _traits->height = height;
        _traits->pbuffer = true;
        _traits->stencil = 8; // interlaced stereo needs it
        setState(new osg::State);
        getState()->setGraphicsContext(this);
        getState()->setContextID(createNewContextID());
        // A failed viewer may have left invalid extensions under this context ID.
        osg::GLExtensions::Set(getState()->getContextID(), nullptr);
    }

    /// Returns an error message; empty on success.
    std::string open()
    {
        const auto getPlatformDisplay = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(
            eglGetProcAddress("eglGetPlatformDisplayEXT"));
        if (getPlatformDisplay)
            _display =
                getPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
        if (_display == EGL_NO_DISPLAY)
            return "this EGL has no surfaceless platform (Debian: libgl1-mesa-dri, libegl-mesa0)";
        if (!eglInitialize(_display, nullptr, nullptr))
            return std::string("eglInitialize: ") + eglErrorText();
        if (!eglBindAPI(EGL_OPENGL_API))
            return std::string("eglBindAPI(OpenGL): ") + eglErrorText();
        const EGLint wanted[] = {EGL_SURFACE_TYPE,
                                 EGL_PBUFFER_BIT,
                                 EGL_RENDERABLE_TYPE,
                                 EGL_OPENGL_BIT,
                                 EGL_RED_SIZE,
                                 8,
                                 EGL_GREEN_SIZE,
                                 8,
                                 EGL_BLUE_SIZE,
                                 8,
                                 EGL_DEPTH_SIZE,
                                 24,
                                 EGL_STENCIL_SIZE,
                                 8,
                                 EGL_NONE};
        EGLConfig config = nullptr;
        EGLint found = 0;
        if (!eglChooseConfig(_display, wanted, &config, 1, &found) || found < 1)
            return "no EGL configuration with 8-bit colours, a 24-bit depth buffer, stencils "
                   "and desktop OpenGL";
        const EGLint size[] = {EGL_WIDTH, _traits->width, EGL_HEIGHT, _traits->height, EGL_NONE};
        _surface = eglCreatePbufferSurface(_display, config, size);
        if (_surface == EGL_NO_SURFACE)
            return std::string("eglCreatePbufferSurface: ") + eglErrorText();
        _context = eglCreateContext(_display, config, EGL_NO_CONTEXT, nullptr);
        if (_context == EGL_NO_CONTEXT) return std::string("eglCreateContext: ") + eglErrorText();
        return {};
    }

    bool valid() const override { return _context != EGL_NO_CONTEXT; }
    bool realizeImplementation() override
    {
        _realized = valid();
        return _realized;
    }
    bool isRealizedImplementation() const override { return _realized; }
    void closeImplementation() override
    {
        // Destroying the current context leaves it current, and the next one would get no OpenGL.
        if (eglGetCurrentContext() == _context) releaseContextImplementation();
        if (_context != EGL_NO_CONTEXT) eglDestroyContext(_display, _context);
        if (_surface != EGL_NO_SURFACE) eglDestroySurface(_display, _surface);
        _context = EGL_NO_CONTEXT;
        _surface = EGL_NO_SURFACE;
        _realized = false;
    }
    bool makeCurrentImplementation() override
    {
        // The API is bound per thread.
        return eglBindAPI(EGL_OPENGL_API) && eglMakeCurrent(_display, _surface, _surface, _context);
    }
    bool makeContextCurrentImplementation(osg::GraphicsContext* /*readContext*/) override
    {
        return makeCurrentImplementation();
    }
    bool releaseContextImplementation() override
    {
        return eglMakeCurrent(_display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    }
    void bindPBufferToTextureImplementation(GLenum /*buffer*/) override {}
    void swapBuffersImplementation() override { glFinish(); }

protected:
    ~SurfacelessContext() override { close(true); }

private:
    EGLDisplay _display = EGL_NO_DISPLAY;
    EGLSurface _surface = EGL_NO_SURFACE;
    EGLContext _context = EGL_NO_CONTEXT;
    bool _realized = false;
};

} // namespace

bool haveDisplay()
{
    const char* display = std::getenv("DISPLAY");
    return display && *display;
}

osg::ref_ptr<osg::GraphicsContext> createOffscreenContext(int width, int height, std::string* error)
{
    osg::ref_ptr<SurfacelessContext> context = new SurfacelessContext(width, height);
    const std::string problem = context->open();
    if (!problem.empty())
    {
        if (error) *error = "no OpenGL without a display: " + problem;
        return nullptr;
    }
    return context;
}

bool setUpOffscreen(
    osgViewer::Viewer& viewer, int width, int height, double fovy_deg, std::string* error)
{
    const osg::ref_ptr<osg::GraphicsContext> context = createOffscreenContext(width, height, error);
    if (!context) return false;
    osg::Camera* camera = viewer.getCamera();
    camera->setGraphicsContext(context);
    camera->setViewport(0, 0, width, height);
    camera->setProjectionMatrixAsPerspective(
        fovy_deg, static_cast<double>(width) / height, 0.01, 10.0);
    viewer.setThreadingModel(osgViewer::ViewerBase::SingleThreaded);
    viewer.realize();
    return true;
}

FrameGrabber::FrameGrabber(int scale) : _scale(scale) {}

void FrameGrabber::operator()(osg::RenderInfo& renderInfo) const
{
    if (!_wanted) return;
    _wanted = false;
    const osg::Viewport* viewport = renderInfo.getCurrentCamera()->getViewport();
    const osg::ref_ptr<osg::Image> read = new osg::Image;
    read->readPixels(0,
                     0,
                     static_cast<int>(viewport->width()),
                     static_cast<int>(viewport->height()),
                     GL_RGB,
                     GL_UNSIGNED_BYTE);
    _image = averagedDown(*read, _scale);
}

osg::ref_ptr<osg::Image> averagedDown(const osg::Image& image, int scale)
{
    osg::ref_ptr<osg::Image> small = new osg::Image;
    const int width = image.s() / scale;
    const int height = image.t() / scale;
    small->allocateImage(width, height, 1, GL_RGB, GL_UNSIGNED_BYTE, 1);
    const int step = static_cast<int>(image.getPixelSizeInBits()) / 8;
    for (int y = 0; y < height; ++y)
    {
        // osg::Image computes the row size at each call of data().
        unsigned char* to = small->data(0, y);
        std::vector<const unsigned char*> rows(scale);
        for (int dy = 0; dy < scale; ++dy)
            rows[dy] = image.data(0, y * scale + dy);
        for (int x = 0; x < width; ++x)
            for (int channel = 0; channel < 3; ++channel)
            {
                int sum = scale * scale / 2;
                for (const unsigned char* row : rows)
                    for (int dx = 0; dx < scale; ++dx)
                        sum += row[(x * scale + dx) * step + channel];
                *to++ = static_cast<unsigned char>(sum / (scale * scale));
            }
    }
    return small;
}

osg::ref_ptr<osg::Image>
renderFlat(osg::Node& scene, int width, int height, const osg::Vec4& background, std::string* error)
{
    constexpr int kScale = 2;
    osgViewer::Viewer viewer;
    viewer.setLightingMode(osg::View::NO_LIGHT);
    if (!setUpOffscreen(viewer, width * kScale, height * kScale, 30.0, error)) return nullptr;
    osg::Camera* camera = viewer.getCamera();
    camera->setClearColor(background);
    camera->setProjectionMatrixAsOrtho2D(0, width, 0, height);
    camera->setViewMatrix(osg::Matrix::identity());
    camera->setComputeNearFarMode(osg::CullSettings::DO_NOT_COMPUTE_NEAR_FAR);
    const osg::ref_ptr<FrameGrabber> grabber = new FrameGrabber(kScale);
    camera->setFinalDrawCallback(grabber);
    viewer.setSceneData(&scene);
    // The first frame compiles the fonts' glyphs.
    viewer.frame();
    grabber->request();
    viewer.frame();
    return grabber->image();
}

} // namespace midair::samples
