#include "device/DeviceUri.h"
#include "engine-bridge/hands/opening/HandOpening.h"
#include "engine-bridge/hands/openxr/OpenXrHandSource.h"
#include "engine-bridge/hands/openxr/OpenXrView.h"
#include "engine-bridge/scene/Convert.h"
#include "haptics/base/InputError.h"
#include "haptics/base/threads/SteadyClock.h"
#include "plugin/display/GlxContext.h"
#include "plugin/display/ScenesBelow.h"
#include "plugin/engine/SceneAccess.h"
#include "plugin/overlays/HidingHands.h"
#include "plugin/overlays/hud/HudRoom.h"

#include <osgMidair/DisplayView>
#include <osgMidair/HeadsetView>
#include <osgMidair/XrSession>

#include <osg/Camera>
#include <osg/GLExtensions>
#include <osg/Notify>
#include <osg/Texture2D>
#include <osg/observer_ptr>
#include <osgGA/GUIEventHandler>
#include <osgViewer/Viewer>

#include <algorithm>
#include <array>
#include <exception>
#include <optional>
#include <utility>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

using midair::bridge::OpenXrBlend;
using midair::bridge::OpenXrEye;
using midair::bridge::OpenXrEyes;
using midair::bridge::OpenXrView;
using midair::bridge::toOsg;

constexpr double kHeadsetNear_m = 0.02; ///< hands don't come closer to the eyes
constexpr double kHeadsetFar_m = 20.0;
// A lost session is retried at once, then with pauses that double.
constexpr double kFirstRetry_s = 5.0;
constexpr double kLastRetry_s = 60.0;
// Position of the sheet of figures before the head, and its size.
constexpr double kSheetBefore_m = 0.8;
constexpr double kSheetWidth_m = 0.8;
constexpr double kSheetHeight_m = 0.6;

/// An eye's picture, drawn by OSG and copied into the runtime's.
struct EyePicture
{
    osg::ref_ptr<osg::Camera> camera;
    osg::ref_ptr<osg::Texture2D> color;
    osg::ref_ptr<osg::Texture2D> depth;
    int width = 0;
    int height = 0;
};

osg::ref_ptr<osg::Texture2D> textureOf(int width, int height, int format, bool isDepth)
{
    osg::ref_ptr<osg::Texture2D> texture = new osg::Texture2D;
    texture->setTextureSize(width, height);
    texture->setInternalFormat(format);
    texture->setSourceFormat(isDepth ? GL_DEPTH_COMPONENT : GL_RGBA);
    texture->setSourceType(isDepth ? GL_FLOAT : GL_UNSIGNED_BYTE);
    texture->setFilter(osg::Texture::MIN_FILTER, osg::Texture::LINEAR);
    texture->setFilter(osg::Texture::MAG_FILTER, osg::Texture::LINEAR);
    texture->setResizeNonPowerOfTwoHint(false);
    return texture;
}

/// Copies between textures, and to the window, with two framebuffers of its own.
class Copier
{
public:
    struct Part
    {
        GLuint texture = 0;
        int width = 0;
        int height = 0;
    };

    /// \a mask: GL_COLOR_BUFFER_BIT or GL_DEPTH_BUFFER_BIT. Without a texture in \a to, copies to
    /// the window. OSG's scissors are the drawn viewport, which is all of either.
    void copy(osg::State& state, GLbitfield mask, const Part& from, const Part& to)
    {
        osg::GLExtensions* gl = state.get<osg::GLExtensions>();
        if (!gl || !gl->isFrameBufferObjectSupported || !gl->glBlitFramebuffer) return;
        if (_buffers[0] == 0) gl->glGenFramebuffers(2, _buffers.data());
        const GLenum point =
            mask == GL_COLOR_BUFFER_BIT ? GL_COLOR_ATTACHMENT0_EXT : GL_DEPTH_ATTACHMENT_EXT;
        const bool isWindow = to.texture == 0;
        const auto attach = [&](GLenum target, GLuint buffer, GLuint texture)
        {
            gl->glBindFramebuffer(target, buffer);
            gl->glFramebufferTexture2D(target, point, GL_TEXTURE_2D, texture, 0);
        };
        attach(GL_READ_FRAMEBUFFER_EXT, _buffers[0], from.texture);
        if (isWindow)
            gl->glBindFramebuffer(GL_DRAW_FRAMEBUFFER_EXT, 0);
        else
            attach(GL_DRAW_FRAMEBUFFER_EXT, _buffers[1], to.texture);
        gl->glBlitFramebuffer(0,
                              0,
                              from.width,
                              from.height,
                              0,
                              0,
                              to.width,
                              to.height,
                              mask,
                              isWindow ? GL_LINEAR : GL_NEAREST);
        // Textures of the session must not stay attached.
        attach(GL_READ_FRAMEBUFFER_EXT, _buffers[0], 0);
        if (!isWindow) attach(GL_DRAW_FRAMEBUFFER_EXT, _buffers[1], 0);
        gl->glBindFramebuffer(GL_FRAMEBUFFER_EXT, 0);
    }

private:
    std::array<GLuint, 2> _buffers{};
};

GLuint nameOf(const osg::Texture2D& texture, const osg::State& state)
{
    const osg::Texture::TextureObject* object = texture.getTextureObject(state.getContextID());
    return object ? object->id() : 0;
}

} // namespace

class HeadsetView::Inside
{
public:
    Inside(const midair::bridge::OpenXrOptions& options, const Eigen::Isometry3d& placement) :
        _options(options),
        _placement(placement),
        _headset(std::make_unique<OpenXrView>(options, placement.inverse()))
    {
    }

    static bool isAttachedTo(osgViewer::View& view);
    bool attach(osgViewer::View& view, HeadsetView& owner, std::string& error);

    /// Call it before the update traversal of frame \a number: follows the runtime, and waits until
    /// it asks for a frame.
    void beginFrame(unsigned int number);
    /// Call it after the traversal: moves the eyes to their predicted pose.
    void look(osgViewer::View& view);
    void startDrawing();
    void endDrawing(osg::RenderInfo& info);
    void drawMirror(osg::RenderInfo& info);
    /// Call it with its context current, if there still is one.
    void close();

    bool isRunning() const { return _frame.isWanted; }
    osg::Matrixd head() const { return toOsg(inUnits(_head).matrix()); }
    osg::Matrixd sheet() const
    {
        return osg::Matrixd::scale(kSheetWidth_m, kSheetHeight_m, 1.0) *
               osg::Matrixd::translate(
                   -0.5 * kSheetWidth_m, -0.5 * kSheetHeight_m, -kSheetBefore_m) *
               osg::Matrixd::scale(1.0 / _shown.unit_m, 1.0 / _shown.unit_m, 1.0 / _shown.unit_m) *
               head();
    }
    std::string status() const { return _headset->status(); }
    std::vector<std::string> messages() const { return _messages.all(); }

private:
    class EachFrame;
    class EyeCamera;
    class Eyes;
    class Begin;
    class End;
    class Mirror;

    struct Frame
    {
        unsigned int number = 0;
        bool isWanted = false; ///< the runtime asked for it
        bool isWaited = false; ///< waited for but not begun
    };
    /// Contents of the headset.
    struct Shown
    {
        std::vector<osg::observer_ptr<HapticScene>> scenes;
        double looked_s = -HidingHands::kLookAgain_s; ///< for hands, on the viewer's clock
        HidingHands hands;                            ///< where the room is visible
        double unit_m = 1.0;
    };
    struct Retry
    {
        double at_s = 0.0; ///< steady clock
        double pause_s = 0.0;
        bool isOver = false; ///< no session will follow
    };

    Eigen::Isometry3d inUnits(Eigen::Isometry3d pose) const
    {
        pose.translation() /= _shown.unit_m;
        return pose;
    }
    osg::GraphicsContext* context() const
    {
        const osgViewer::View* view = _view.get();
        return view ? const_cast<osg::GraphicsContext*>(view->getCamera()->getGraphicsContext())
                    : nullptr;
    }
    void addEye(int which, osgViewer::View& view);
    void begin();
    void lose(const std::string& why);
    void dropFrame();
    void setShown(bool isShown);
    void findScenes(osgViewer::View& view);
    void toggleMute();
    void tellScenes();
    void tellNew();
    void tell(const std::string& text)
    {
        if (_messages.say({midair::base::MessageCode::HANDS_SOURCE, text}))
            OSG_WARN << "osgMidair: headset: " << text << std::endl;
    }

    const midair::bridge::OpenXrOptions _options;
    const Eigen::Isometry3d _placement;
    std::unique_ptr<OpenXrView> _headset;
    osg::observer_ptr<osgViewer::View> _view;
    std::array<EyePicture, 2> _eyes;
    osg::ref_ptr<WorldSheet> _sheet = new WorldSheet;
    Eigen::Isometry3d _head = Eigen::Isometry3d::Identity(); ///< m
    Shown _shown;
    osg::Node::NodeMask _cullMask = ~0U; ///< of the viewer's own camera
    Frame _frame;
    Retry _retry;
    Copier _copier;
    midair::base::MessageLog _messages;
    std::size_t _told = 0;
};

/// Begins each frame; keeps the headset alive for the viewer.
class HeadsetView::Inside::EachFrame : public osgGA::GUIEventHandler
{
public:
    explicit EachFrame(HeadsetView& owner) : _owner(&owner) {}
    using osgGA::GUIEventHandler::handle;
    bool handle(const osgGA::GUIEventAdapter& event, osgGA::GUIActionAdapter& action) override
    {
        auto* view = dynamic_cast<osgViewer::View*>(&action);
        if (event.getEventType() == osgGA::GUIEventAdapter::FRAME && view)
            _owner->_inside->beginFrame(view->getFrameStamp()->getFrameNumber());
        return false;
    }

private:
    const osg::ref_ptr<HeadsetView> _owner;
};

/// Ends the session before its context does.
class HeadsetView::Inside::EyeCamera : public osg::Camera
{
public:
    explicit EyeCamera(Inside& inside) : _inside(inside) {}
    void releaseGLObjects(osg::State* state) const override
    {
        _inside.close();
        osg::Camera::releaseGLObjects(state);
    }

private:
    Inside& _inside;
};

class HeadsetView::Inside::Eyes : public osg::View::Slave::UpdateSlaveCallback
{
public:
    explicit Eyes(Inside& inside) : _inside(inside) {}
    void updateSlave(osg::View& view, osg::View::Slave& /*slave*/) override
    {
        _inside.look(static_cast<osgViewer::View&>(view));
    }

private:
    Inside& _inside;
};

class HeadsetView::Inside::Begin : public osg::Camera::DrawCallback
{
public:
    explicit Begin(Inside& inside) : _inside(inside) {}
    void operator()(osg::RenderInfo& /*info*/) const override { _inside.startDrawing(); }

private:
    Inside& _inside;
};

class HeadsetView::Inside::End : public osg::Camera::DrawCallback
{
public:
    explicit End(Inside& inside) : _inside(inside) {}
    void operator()(osg::RenderInfo& info) const override { _inside.endDrawing(info); }

private:
    Inside& _inside;
};

class HeadsetView::Inside::Mirror : public osg::Camera::DrawCallback
{
public:
    explicit Mirror(Inside& inside) : _inside(inside) {}
    void operator()(osg::RenderInfo& info) const override { _inside.drawMirror(info); }

private:
    Inside& _inside;
};

bool HeadsetView::Inside::isAttachedTo(osgViewer::View& view)
{
    const auto& handlers = view.getEventHandlers();
    return std::any_of(handlers.begin(),
                       handlers.end(),
                       [](const auto& each)
                       { return dynamic_cast<const EachFrame*>(each.get()) != nullptr; });
}

bool HeadsetView::Inside::attach(osgViewer::View& view, HeadsetView& owner, std::string& error)
{
    osg::Camera& camera = *view.getCamera();
    if (!camera.getGraphicsContext())
        error = "the viewer's camera has no window yet: set it up before the headset";
    else if (view.getNumSlaves() > 0)
        error = fmt::format("the viewer has {} slave cameras; a headset needs a viewer without any",
                            view.getNumSlaves());
    else if (DisplayView::isOn(view) || isAttachedTo(view))
        error = "the viewer has a display already";
    else if (_view.valid())
        error = "the headset shows another view";
    if (!error.empty()) return false;
    _view = &view;
    if (auto* viewer = view.getViewerBase())
        viewer->setThreadingModel(osgViewer::ViewerBase::SingleThreaded);
    // Debian's OSG uses these traits for a window that isn't realized yet.
    if (const auto* traits = camera.getGraphicsContext()->getTraits())
        const_cast<osg::GraphicsContext::Traits*>(traits)->vsync = false;
    _cullMask = camera.getCullMask();
    addEye(0, view);
    addEye(1, view);
    camera.addFinalDrawCallback(new Mirror(*this));
    view.addEventHandler(new EachFrame(owner));
    setShown(false);
    return true;
}

void HeadsetView::Inside::addEye(int which, osgViewer::View& view)
{
    EyePicture& eye = _eyes[static_cast<std::size_t>(which)];
    eye.width = _headset->width(which);
    eye.height = _headset->height(which);
    const int depth = _headset->depthFormat();
    eye.color = textureOf(eye.width, eye.height, GL_RGBA8, false);
    eye.depth = textureOf(eye.width, eye.height, depth != 0 ? depth : GL_DEPTH_COMPONENT24, true);
    eye.camera = new EyeCamera(*this);
    osg::Camera& camera = *eye.camera;
    camera.setName(which == 0 ? "left eye" : "right eye");
    camera.setGraphicsContext(view.getCamera()->getGraphicsContext());
    camera.setViewport(0, 0, eye.width, eye.height);
    camera.setReferenceFrame(osg::Transform::ABSOLUTE_RF);
    camera.setRenderTargetImplementation(osg::Camera::FRAME_BUFFER_OBJECT);
    camera.setRenderOrder(osg::Camera::PRE_RENDER, which);
    camera.setClearMask(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    camera.setComputeNearFarMode(osg::CullSettings::DO_NOT_COMPUTE_NEAR_FAR);
    camera.setProjectionResizePolicy(osg::Camera::FIXED);
    camera.setAllowEventFocus(false);
    camera.attach(osg::Camera::COLOR_BUFFER, eye.color);
    camera.attach(osg::Camera::DEPTH_BUFFER, eye.depth);
    camera.setUserData(_sheet);
    if (which == 0)
        camera.addInitialDrawCallback(new Begin(*this));
    else
        camera.addFinalDrawCallback(new End(*this));
    view.addSlave(&camera, osg::Matrix::identity(), osg::Matrix::identity(), true);
    if (which == 0) view.getSlave(0)._updateSlaveCallback = new Eyes(*this);
}

/// True: the eyes are drawn, and the window shows one of them. False: the window's own camera
/// draws.
void HeadsetView::Inside::setShown(bool isShown)
{
    osgViewer::View* view = _view.get();
    if (!view) return;
    view->getCamera()->setCullMask(isShown ? 0U : _cullMask);
    for (EyePicture& eye : _eyes)
    {
        eye.camera->setNodeMask(isShown ? ~0U : 0U);
        eye.camera->setCullMask(_cullMask);
    }
}

void HeadsetView::Inside::begin()
{
    osg::GraphicsContext* window = context();
    if (!window || !window->isRealized() || !window->makeCurrent()) return;
    std::string error;
    const midair::bridge::OpenXrGraphics graphics = currentGlx(error);
    if (!error.empty())
    {
        _retry.isOver = true;
        tell(error + "; the window shows the scene");
    }
    else
        try
        {
            stopWaitingForScreen();
            _headset->begin(graphics);
            _retry.pause_s = 0.0;
        }
        catch (const midair::base::InputError& wrong)
        {
            lose(wrong.what());
        }
    window->releaseContext();
}

/// Ends the session.
void HeadsetView::Inside::lose(const std::string& why)
{
    tell(why);
    _retry.isOver = !_headset->mayReturn();
    _retry.at_s = midair::base::steadySeconds() + _retry.pause_s;
    _retry.pause_s = std::clamp(2.0 * _retry.pause_s, kFirstRetry_s, kLastRetry_s);
    osg::GraphicsContext* window = context();
    const bool isCurrent = window && window->isRealized() && window->makeCurrent();
    _headset->end();
    if (isCurrent) window->releaseContext();
    _frame = {_frame.number, false, false};
}

/// Submits an empty frame that the runtime waits for.
void HeadsetView::Inside::dropFrame()
{
    if (!std::exchange(_frame.isWaited, false)) return;
    osg::GraphicsContext* window = context();
    if (!window || !window->makeCurrent()) return;
    _headset->beginFrame();
    _headset->endFrame(kHeadsetNear_m, kHeadsetFar_m);
    window->releaseContext();
}

void HeadsetView::Inside::beginFrame(unsigned int number)
{
    if (number == _frame.number) return;
    _frame.number = number;
    if (!_headset->hasSession() && !_retry.isOver && midair::base::steadySeconds() >= _retry.at_s)
        begin();
    const bool wasWanted = _frame.isWanted;
    _frame.isWanted = false;
    try
    {
        if (_headset->hasSession())
        {
            dropFrame();
            _frame.isWanted = _frame.isWaited = _headset->wait();
        }
    }
    catch (const midair::base::InputError& wrong)
    {
        lose(wrong.what());
    }
    if (wasWanted != _frame.isWanted) setShown(_frame.isWanted);
    if (_frame.isWanted) tellScenes();
    tellNew();
    if (_headset->takeMute()) toggleMute();
}

/// Tells the scenes their display time and the headset before they are updated.
void HeadsetView::Inside::tellScenes()
{
    const std::optional<double> display_s = _headset->displayTime();
    const std::string recentred = XrSession::getRecentred();
    for (const osg::observer_ptr<HapticScene>& one : _shown.scenes)
    {
        osg::ref_ptr<HapticScene> scene;
        if (!one.lock(scene)) continue;
        if (display_s) scene->setDisplayTime(*display_s);
        SceneAccess::engine(*scene).setViewing(
            {nullptr,
             _head,
             recentred.empty() ? "the headset's position is not measured" : recentred});
    }
}

void HeadsetView::Inside::tellNew()
{
    for (const std::string& text : _headset->messages(_told))
        tell(text);
}

void HeadsetView::Inside::findScenes(osgViewer::View& view)
{
    _shown.scenes.clear();
    _shown.unit_m = 1.0;
    if (!view.getSceneData()) return;
    const std::vector<HapticScene*> found = ScenesBelow(*view.getSceneData()).found;
    _shown.scenes.assign(found.begin(), found.end());
    if (!found.empty() && found.front()->getMetresPerUnit() > 0.0)
        _shown.unit_m = found.front()->getMetresPerUnit();
}

/// One button mutes everything that plays, or unmutes if all is muted.
void HeadsetView::Inside::toggleMute()
{
    if (osgViewer::View* view = _view.get()) findScenes(*view);
    const bool isMuted =
        std::all_of(_shown.scenes.begin(),
                    _shown.scenes.end(),
                    [](const auto& scene) { return !scene.valid() || scene->getMuted(); });
    for (const auto& scene : _shown.scenes)
        if (scene.valid()) scene->setMuted(!isMuted);
}

void HeadsetView::Inside::look(osgViewer::View& view)
{
    beginFrame(view.getFrameStamp()->getFrameNumber()); // for a loop without events
    if (view.getCameraManipulator())
    {
        view.setCameraManipulator(nullptr);
        tell("the viewer's camera manipulator is removed: it would move the scene off the "
             "array");
    }
    if (!_frame.isWanted) return;
    const double now_s = view.getFrameStamp()->getReferenceTime();
    if (now_s - _shown.looked_s >= HidingHands::kLookAgain_s)
    {
        _shown.looked_s = now_s;
        findScenes(view);
    }
    OpenXrEyes eyes;
    try
    {
        if (!_headset->locate(eyes)) return;
    }
    catch (const midair::base::InputError& wrong)
    {
        lose(wrong.what());
        setShown(false);
        return;
    }
    const double near = kHeadsetNear_m / _shown.unit_m;
    const double far = kHeadsetFar_m / _shown.unit_m;
    const bool isOpaque = _headset->blend() == OpenXrBlend::OPAQUE;
    for (std::size_t i = 0; i < eyes.size(); ++i)
    {
        const OpenXrEye& eye = eyes[i];
        osg::Camera& camera = *_eyes[i].camera;
        camera.setViewMatrix(toOsg(inUnits(_placement * eye.pose).inverse().matrix()));
        camera.setProjectionMatrixAsFrustum(
            eye.left * near, eye.right * near, eye.down * near, eye.up * near, near, far);
        osg::Vec4 behind = view.getCamera()->getClearColor();
        behind.a() = 1.0F;
        camera.setClearColor(isOpaque ? behind : osg::Vec4(0.0F, 0.0F, 0.0F, 0.0F));
        camera.setCullMask(_cullMask);
        if (!isOpaque) _shown.hands.drawIn(camera);
    }
    if (!isOpaque && view.getSceneData()) _shown.hands.update(*view.getSceneData(), now_s);
    const Eigen::Quaterniond turn = Eigen::Quaterniond(eyes[0].pose.linear())
                                        .slerp(0.5, Eigen::Quaterniond(eyes[1].pose.linear()));
    _head = _placement * midair::bridge::headPose(
                             0.5 * (eyes[0].pose.translation() + eyes[1].pose.translation()), turn);
    _sheet->toWorld =
        osg::Matrixd::scale(1.0 / _sheet->size.x(), 1.0 / _sheet->size.y(), 1.0) * sheet();
    view.getCamera()->setViewMatrix(osg::Matrixd::inverse(head()));
}

void HeadsetView::Inside::startDrawing()
{
    if (!std::exchange(_frame.isWaited, false)) return;
    try
    {
        _headset->beginFrame();
    }
    catch (const midair::base::InputError& wrong)
    {
        tell(wrong.what()); // the next frame's events report the session's state
        _frame.isWanted = false;
    }
}

void HeadsetView::Inside::endDrawing(osg::RenderInfo& info)
{
    if (!_frame.isWanted) return;
    osg::State& state = *info.getState();
    try
    {
        for (const int i : {0, 1})
        {
            const EyePicture& eye = _eyes[static_cast<std::size_t>(i)];
            const auto part = [&eye](GLuint texture) {
                return Copier::Part{texture, eye.width, eye.height};
            };
            _copier.copy(state,
                         GL_COLOR_BUFFER_BIT,
                         part(nameOf(*eye.color, state)),
                         part(_headset->picture(i)));
            if (_headset->depthFormat() != 0)
                _copier.copy(state,
                             GL_DEPTH_BUFFER_BIT,
                             part(nameOf(*eye.depth, state)),
                             part(_headset->depth(i)));
        }
        _headset->endFrame(kHeadsetNear_m, kHeadsetFar_m);
    }
    catch (const midair::base::InputError& wrong)
    {
        tell(wrong.what());
    }
}

void HeadsetView::Inside::drawMirror(osg::RenderInfo& info)
{
    const osg::Viewport* viewport = info.getCurrentCamera()->getViewport();
    if (!_frame.isWanted || !viewport) return;
    const EyePicture& eye = _eyes[0];
    osg::State& state = *info.getState();
    _copier.copy(state,
                 GL_COLOR_BUFFER_BIT,
                 {nameOf(*eye.color, state), eye.width, eye.height},
                 {0, static_cast<int>(viewport->width()), static_cast<int>(viewport->height())});
}

void HeadsetView::Inside::close()
{
    if (!_headset->hasSession()) return;
    osg::GraphicsContext* window = context();
    const bool isCurrent = window && window->isRealized() && window->makeCurrent();
    _headset->end();
    if (isCurrent) window->releaseContext();
    _frame = {};
    _retry.isOver = true;
}

HeadsetView::HeadsetView(std::unique_ptr<Inside> inside) : _inside(std::move(inside)) {}

HeadsetView::~HeadsetView() = default;

osg::ref_ptr<HeadsetView> HeadsetView::open(const std::string& headset, std::string& error)
{
    try
    {
        midair::device::DeviceUri uri(headset, "headset");
        if (uri.scheme() != "openxr") throw uri.error("should be openxr:");
        const midair::bridge::OpenXrOptions options = midair::bridge::takeOpenXrOptions(uri);
        const Eigen::Isometry3d placement =
            midair::bridge::takePlacement(uri, midair::bridge::OpenXrHandSource::upright());
        uri.rejectUnknown();
        return new HeadsetView(std::make_unique<Inside>(options, placement));
    }
    catch (const std::exception& problem)
    {
        error = problem.what();
    }
    return nullptr;
}

bool HeadsetView::attach(osgViewer::View& view, std::string& error)
{
    return _inside->attach(view, *this, error);
}

bool HeadsetView::isOn(osgViewer::View& view)
{
    return Inside::isAttachedTo(view);
}

bool HeadsetView::isRunning() const
{
    return _inside->isRunning();
}

osg::Matrixd HeadsetView::getHead() const
{
    return _inside->head();
}

osg::Matrixd HeadsetView::getSheet() const
{
    return _inside->sheet();
}

std::string HeadsetView::getStatus() const
{
    return _inside->status();
}

std::vector<std::string> HeadsetView::getMessages() const
{
    return _inside->messages();
}

} // namespace osgMidair
