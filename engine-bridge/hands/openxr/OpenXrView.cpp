#define XR_USE_GRAPHICS_API_OPENGL
#include "engine-bridge/hands/openxr/OpenXrView.h"

#include "engine-bridge/hands/openxr/OpenXrLending.h"
#include "engine-bridge/hands/openxr/OpenXrSession.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

namespace midair::bridge
{

namespace
{

// Format numbers of OpenGL. The drawn picture is like a window's, and therefore sRGB.
constexpr std::int64_t kSrgb8Alpha8 = 0x8C43;
constexpr std::int64_t kRgba8 = 0x8058;
constexpr std::int64_t kDepth24 = 0x81A6;
constexpr std::int64_t kDepth32F = 0x8CAC;
constexpr std::int64_t kDepth16 = 0x81A5;

constexpr std::uint32_t kMostFormats = 1000; ///< limit of counts from the runtime
constexpr std::uint32_t kMostImages = 16;
constexpr std::uint32_t kMostPixels = 16384; ///< edge of a picture

/// XrGraphicsBindingOpenGLXlibKHR, without the headers of X.
struct XlibBinding
{
    XrStructureType type;
    const void* next;
    void* display;
    std::uint32_t visual;
    void* config;
    unsigned long drawable;
    void* context;
};

/// Functions for pictures and controllers.
struct PictureFunctions
{
    explicit PictureFunctions(const OpenXrInstance& of)
    {
        of.load("xrEnumerateViewConfigurationViews", views);
        of.load("xrEnumerateEnvironmentBlendModes", blendModes);
        of.load("xrGetOpenGLGraphicsRequirementsKHR", requirements);
        of.load("xrEnumerateSwapchainFormats", formats);
        of.load("xrCreateSwapchain", createSwapchain);
        of.load("xrDestroySwapchain", destroySwapchain);
        of.load("xrEnumerateSwapchainImages", images);
        of.load("xrAcquireSwapchainImage", acquire);
        of.load("xrWaitSwapchainImage", waitImage);
        of.load("xrReleaseSwapchainImage", release);
        of.load("xrWaitFrame", waitFrame);
        of.load("xrBeginFrame", beginFrame);
        of.load("xrEndFrame", endFrame);
        of.load("xrLocateViews", locateViews);
        of.load("xrStringToPath", path);
        of.load("xrCreateActionSet", createSet);
        of.load("xrDestroyActionSet", destroySet);
        of.load("xrCreateAction", createAction);
        of.load("xrSuggestInteractionProfileBindings", suggest);
        of.load("xrAttachSessionActionSets", attach);
        of.load("xrSyncActions", sync);
        of.load("xrGetActionStateBoolean", button);
        if (!of.has(XR_FB_PASSTHROUGH_EXTENSION_NAME)) return;
        of.load("xrCreatePassthroughFB", createPassthrough);
        of.load("xrDestroyPassthroughFB", destroyPassthrough);
        of.load("xrCreatePassthroughLayerFB", createRoom);
        of.load("xrDestroyPassthroughLayerFB", destroyRoom);
    }

    PFN_xrEnumerateViewConfigurationViews views = nullptr;
    PFN_xrEnumerateEnvironmentBlendModes blendModes = nullptr;
    PFN_xrGetOpenGLGraphicsRequirementsKHR requirements = nullptr;
    PFN_xrEnumerateSwapchainFormats formats = nullptr;
    PFN_xrCreateSwapchain createSwapchain = nullptr;
    PFN_xrDestroySwapchain destroySwapchain = nullptr;
    PFN_xrEnumerateSwapchainImages images = nullptr;
    PFN_xrAcquireSwapchainImage acquire = nullptr;
    PFN_xrWaitSwapchainImage waitImage = nullptr;
    PFN_xrReleaseSwapchainImage release = nullptr;
    PFN_xrWaitFrame waitFrame = nullptr;
    PFN_xrBeginFrame beginFrame = nullptr;
    PFN_xrEndFrame endFrame = nullptr;
    PFN_xrLocateViews locateViews = nullptr;
    PFN_xrStringToPath path = nullptr;
    PFN_xrCreateActionSet createSet = nullptr;
    PFN_xrDestroyActionSet destroySet = nullptr;
    PFN_xrCreateAction createAction = nullptr;
    PFN_xrSuggestInteractionProfileBindings suggest = nullptr;
    PFN_xrAttachSessionActionSets attach = nullptr;
    PFN_xrSyncActions sync = nullptr;
    PFN_xrGetActionStateBoolean button = nullptr;
    PFN_xrCreatePassthroughFB createPassthrough = nullptr;
    PFN_xrDestroyPassthroughFB destroyPassthrough = nullptr;
    PFN_xrCreatePassthroughLayerFB createRoom = nullptr;
    PFN_xrDestroyPassthroughLayerFB destroyRoom = nullptr;
};

template<typename T>
T typed(XrStructureType type)
{
    T structure{};
    structure.type = type;
    return structure;
}

/// Images in rotation; one at a time is drawn into.
struct Swapchain
{
    XrSwapchain handle = XR_NULL_HANDLE;
    std::vector<XrSwapchainImageOpenGLKHR> images;
    bool isHeld = false;  ///< an image is acquired and not released
    bool isDrawn = false; ///< in this frame
};

/// An eye's pictures.
struct Pictures
{
    XrViewConfigurationView size{};
    Swapchain color;
    Swapchain depth;
};

/// The mute button of controllers: the menu button if there is one.
struct MuteButton
{
    const char* profile;
    std::array<const char*, 2> paths;
};

const std::array<MuteButton, 4> kMuteButtons = {
    {{"/interaction_profiles/khr/simple_controller",
      {"/user/hand/left/input/menu/click", "/user/hand/right/input/menu/click"}},
     {"/interaction_profiles/oculus/touch_controller",
      {"/user/hand/left/input/y/click", "/user/hand/right/input/b/click"}},
     {"/interaction_profiles/valve/index_controller",
      {"/user/hand/left/input/b/click", "/user/hand/right/input/b/click"}},
     {"/interaction_profiles/htc/vive_controller",
      {"/user/hand/left/input/menu/click", "/user/hand/right/input/menu/click"}}}};

Eigen::Isometry3d poseOf(const XrPosef& pose)
{
    const XrVector3f& p = pose.position;
    const XrQuaternionf& q = pose.orientation;
    return headPose(Eigen::Vector3f(p.x, p.y, p.z).cast<double>(),
                    Eigen::Quaterniond(Eigen::Quaternionf(q.w, q.x, q.y, q.z)));
}

} // namespace

/// A session and its drawing resources.
class OpenXrView::Inside
{
public:
    Inside(const OpenXrOptions& options, const Eigen::Isometry3d& anchor) :
        _options(options),
        _anchor(anchor)
    {
        const std::string why = OpenXrLending::one().take();
        if (!why.empty()) throw OpenXrError(why, false);
        try
        {
            connect();
        }
        catch (...)
        {
            OpenXrLending::one().give();
            throw;
        }
    }
    ~Inside()
    {
        end();
        OpenXrLending::one().give();
    }
    Inside(const Inside&) = delete;
    Inside& operator=(const Inside&) = delete;

    void begin(const OpenXrGraphics& graphics);
    void end();
    bool wait();
    bool locate(OpenXrEyes& eyes);
    void beginFrame();
    std::uint32_t acquire(Swapchain& chain);
    void endFrame(double near_m, double far_m);

    bool hasSession() const { return _session != nullptr; }
    bool isRunning() const { return _session && _session->isRunning(); }
    Pictures& eye(int i) { return _eyes[static_cast<std::size_t>(i)]; }
    std::int64_t depthFormat() const { return _depthFormat; }
    OpenXrBlend blend() const { return _room.blend; }
    const std::string& runtime() const { return _runtime; }
    bool mayReturn() const { return _mayReturn; }
    bool takeMute() { return std::exchange(_mute.isPressed, false); }
    std::optional<double> displayTime() const
    {
        return _instance ? _instance->steadyTime(_frame.state.predictedDisplayTime) : std::nullopt;
    }

private:
    /// Background behind the drawn picture.
    struct Room
    {
        OpenXrBlend blend = OpenXrBlend::OPAQUE;
        XrEnvironmentBlendMode mode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
        XrPassthroughFB passthrough = XR_NULL_HANDLE;
        XrPassthroughLayerFB layer = XR_NULL_HANDLE;
    };
    struct Frame
    {
        XrFrameState state{};
        std::array<XrView, 2> views{};
        bool isBegun = false;
        bool isLocated = false;
    };
    struct Mute
    {
        XrActionSet set = XR_NULL_HANDLE;
        XrAction action = XR_NULL_HANDLE;
        bool isPressed = false;
    };

    void connect();
    void beginIn(const OpenXrGraphics& graphics);
    void makePictures();
    std::int64_t chooseFormat(const std::vector<std::int64_t>& offered,
                              std::initializer_list<std::int64_t> wanted) const;
    void makeSwapchain(Swapchain& chain,
                       const XrViewConfigurationView& size,
                       std::int64_t format,
                       XrSwapchainUsageFlags usage);
    void chooseRoom();
    void makePassthrough();
    void makeMuteButton();
    XrPath pathOf(const char* text) const;
    void readMuteButton();
    void release(Swapchain& chain);
    void check(XrResult result, const char* call);
    void say(const std::string& text) { OpenXrLending::one().say(text); }

    const OpenXrOptions _options;
    const Eigen::Isometry3d _anchor; ///< place at which the space is anchored to the room
    std::shared_ptr<OpenXrInstance> _instance;
    std::unique_ptr<PictureFunctions> _xr;
    std::unique_ptr<OpenXrSession> _session;
    std::array<Pictures, 2> _eyes;
    std::int64_t _depthFormat = 0;
    Room _room;
    Frame _frame;
    Mute _mute;
    std::string _runtime;
    bool _mayReturn = true;
};

void OpenXrView::Inside::connect()
{
    _instance = std::make_shared<OpenXrInstance>(_options.loader, OpenXrInstance::Use::PICTURE);
    _xr = std::make_unique<PictureFunctions>(*_instance);
    _runtime = _instance->runtime();
    std::uint32_t count = 0;
    std::array<XrViewConfigurationView, 2> views{};
    for (XrViewConfigurationView& view : views)
        view.type = XR_TYPE_VIEW_CONFIGURATION_VIEW;
    _instance->check(_xr->views(_instance->handle(),
                                _instance->system(),
                                XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO,
                                2,
                                &count,
                                views.data()),
                     "xrEnumerateViewConfigurationViews");
    for (std::size_t i = 0; i < views.size(); ++i)
    {
        _eyes[i].size = views[i];
        if (count != 2 || views[i].recommendedImageRectWidth == 0 ||
            views[i].recommendedImageRectHeight == 0 ||
            views[i].recommendedImageRectWidth > kMostPixels ||
            views[i].recommendedImageRectHeight > kMostPixels)
            throw OpenXrError(_runtime + " has no pictures for two eyes; no picture in a headset",
                              false);
    }
    chooseRoom();
}

/// Takes the first mode offered, which the runtime prefers.
void OpenXrView::Inside::chooseRoom()
{
    std::array<XrEnvironmentBlendMode, 8> modes{};
    std::uint32_t count = 0;
    _instance->check(_xr->blendModes(_instance->handle(),
                                     _instance->system(),
                                     XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO,
                                     static_cast<std::uint32_t>(modes.size()),
                                     &count,
                                     modes.data()),
                     "xrEnumerateEnvironmentBlendModes");
    _room = {};
    if (count > 0) _room.mode = modes[0];
    if (_room.mode == XR_ENVIRONMENT_BLEND_MODE_ADDITIVE) _room.blend = OpenXrBlend::ADDITIVE;
    if (_room.mode == XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND) _room.blend = OpenXrBlend::ALPHA;
}

void OpenXrView::Inside::begin(const OpenXrGraphics& graphics)
{
    if (!_instance) connect();
    try
    {
        beginIn(graphics);
    }
    catch (const OpenXrError& error)
    {
        _mayReturn = error.mayPass();
        end();
        throw;
    }
    OpenXrLending::one().lend(_session.get());
}

void OpenXrView::Inside::beginIn(const OpenXrGraphics& graphics)
{
    auto needed = typed<XrGraphicsRequirementsOpenGLKHR>(XR_TYPE_GRAPHICS_REQUIREMENTS_OPENGL_KHR);
    _instance->check(_xr->requirements(_instance->handle(), _instance->system(), &needed),
                     "xrGetOpenGLGraphicsRequirementsKHR");
    const XlibBinding binding = {XR_TYPE_GRAPHICS_BINDING_OPENGL_XLIB_KHR,
                                 nullptr,
                                 graphics.display,
                                 graphics.visual,
                                 graphics.config,
                                 graphics.drawable,
                                 graphics.context};
    _session = std::make_unique<OpenXrSession>(
        _instance, &binding, _options.space, [this](const std::string& text) { say(text); });
    makePictures();
    makePassthrough();
    makeMuteButton();
}

std::int64_t OpenXrView::Inside::chooseFormat(const std::vector<std::int64_t>& offered,
                                              std::initializer_list<std::int64_t> wanted) const
{
    for (const std::int64_t format : wanted)
        if (std::find(offered.begin(), offered.end(), format) != offered.end()) return format;
    return 0;
}

void OpenXrView::Inside::makePictures()
{
    std::uint32_t count = 0;
    check(_xr->formats(_session->handle(), 0, &count, nullptr), "xrEnumerateSwapchainFormats");
    std::vector<std::int64_t> offered(std::min(count, kMostFormats));
    check(
        _xr->formats(
            _session->handle(), static_cast<std::uint32_t>(offered.size()), &count, offered.data()),
        "xrEnumerateSwapchainFormats");
    const std::int64_t color = chooseFormat(offered, {kSrgb8Alpha8, kRgba8});
    if (color == 0)
        throw OpenXrError(
            _runtime + " supports no image format with 8 bits a colour; no picture in a headset",
            false);
    _depthFormat = _instance->has(XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME)
                       ? chooseFormat(offered, {kDepth24, kDepth32F, kDepth16})
                       : 0;
    for (Pictures& eye : _eyes)
    {
        makeSwapchain(eye.color, eye.size, color, XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT);
        if (_depthFormat != 0)
            makeSwapchain(
                eye.depth, eye.size, _depthFormat, XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
    }
}

void OpenXrView::Inside::makeSwapchain(Swapchain& chain,
                                       const XrViewConfigurationView& size,
                                       std::int64_t format,
                                       XrSwapchainUsageFlags usage)
{
    auto info = typed<XrSwapchainCreateInfo>(XR_TYPE_SWAPCHAIN_CREATE_INFO);
    info.usageFlags = usage;
    info.format = format;
    info.sampleCount = 1;
    info.width = size.recommendedImageRectWidth;
    info.height = size.recommendedImageRectHeight;
    info.faceCount = info.arraySize = info.mipCount = 1;
    chain = {};
    check(_xr->createSwapchain(_session->handle(), &info, &chain.handle), "xrCreateSwapchain");
    std::uint32_t count = 0;
    check(_xr->images(chain.handle, 0, &count, nullptr), "xrEnumerateSwapchainImages");
    chain.images.resize(std::min(count, kMostImages),
                        {XR_TYPE_SWAPCHAIN_IMAGE_OPENGL_KHR, nullptr, 0});
    check(_xr->images(chain.handle,
                      static_cast<std::uint32_t>(chain.images.size()),
                      &count,
                      reinterpret_cast<XrSwapchainImageBaseHeader*>(chain.images.data())),
          "xrEnumerateSwapchainImages");
}

/// Shows the room through the headset's cameras, if it is not see-through.
void OpenXrView::Inside::makePassthrough()
{
    if (!_xr->createPassthrough || _room.mode != XR_ENVIRONMENT_BLEND_MODE_OPAQUE) return;
    auto seen = typed<XrSystemPassthroughPropertiesFB>(XR_TYPE_SYSTEM_PASSTHROUGH_PROPERTIES_FB);
    auto properties = typed<XrSystemProperties>(XR_TYPE_SYSTEM_PROPERTIES);
    properties.next = &seen;
    const XrResult result = _instance->functions().getSystemProperties(
        _instance->handle(), _instance->system(), &properties);
    if (XR_FAILED(result) || !seen.supportsPassthrough) return;
    auto info = typed<XrPassthroughCreateInfoFB>(XR_TYPE_PASSTHROUGH_CREATE_INFO_FB);
    info.flags = XR_PASSTHROUGH_IS_RUNNING_AT_CREATION_BIT_FB;
    check(_xr->createPassthrough(_session->handle(), &info, &_room.passthrough),
          "xrCreatePassthroughFB");
    auto layer = typed<XrPassthroughLayerCreateInfoFB>(XR_TYPE_PASSTHROUGH_LAYER_CREATE_INFO_FB);
    layer.passthrough = _room.passthrough;
    layer.flags = XR_PASSTHROUGH_IS_RUNNING_AT_CREATION_BIT_FB;
    layer.purpose = XR_PASSTHROUGH_LAYER_PURPOSE_RECONSTRUCTION_FB;
    check(_xr->createRoom(_session->handle(), &layer, &_room.layer), "xrCreatePassthroughLayerFB");
    _room.blend = OpenXrBlend::ALPHA;
}

XrPath OpenXrView::Inside::pathOf(const char* text) const
{
    XrPath path = XR_NULL_PATH;
    _instance->check(_xr->path(_instance->handle(), text, &path), "xrStringToPath");
    return path;
}

void OpenXrView::Inside::makeMuteButton()
{
    auto set = typed<XrActionSetCreateInfo>(XR_TYPE_ACTION_SET_CREATE_INFO);
    std::strcpy(set.actionSetName, "haptics");
    std::strcpy(set.localizedActionSetName, "Haptics");
    check(_xr->createSet(_instance->handle(), &set, &_mute.set), "xrCreateActionSet");
    auto action = typed<XrActionCreateInfo>(XR_TYPE_ACTION_CREATE_INFO);
    std::strcpy(action.actionName, "mute");
    std::strcpy(action.localizedActionName, "Mute the array");
    action.actionType = XR_ACTION_TYPE_BOOLEAN_INPUT;
    check(_xr->createAction(_mute.set, &action, &_mute.action), "xrCreateAction");
    for (const MuteButton& button : kMuteButtons)
    {
        std::vector<XrActionSuggestedBinding> bindings;
        for (const char* path : button.paths)
            bindings.push_back({_mute.action, pathOf(path)});
        auto suggested = typed<XrInteractionProfileSuggestedBinding>(
            XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING);
        suggested.interactionProfile = pathOf(button.profile);
        suggested.countSuggestedBindings = static_cast<std::uint32_t>(bindings.size());
        suggested.suggestedBindings = bindings.data();
        _xr->suggest(_instance->handle(), &suggested); // the runtime may not know the controller
    }
    auto attached = typed<XrSessionActionSetsAttachInfo>(XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO);
    attached.countActionSets = 1;
    attached.actionSets = &_mute.set;
    check(_xr->attach(_session->handle(), &attached), "xrAttachSessionActionSets");
}

void OpenXrView::Inside::readMuteButton()
{
    const XrActiveActionSet active = {_mute.set, XR_NULL_PATH};
    auto sync = typed<XrActionsSyncInfo>(XR_TYPE_ACTIONS_SYNC_INFO);
    sync.countActiveActionSets = 1;
    sync.activeActionSets = &active;
    // Without the user's focus there are no actions.
    if (_xr->sync(_session->handle(), &sync) != XR_SUCCESS) return;
    auto asked = typed<XrActionStateGetInfo>(XR_TYPE_ACTION_STATE_GET_INFO);
    asked.action = _mute.action;
    auto state = typed<XrActionStateBoolean>(XR_TYPE_ACTION_STATE_BOOLEAN);
    if (XR_FAILED(_xr->button(_session->handle(), &asked, &state))) return;
    if (state.isActive && state.changedSinceLastSync && state.currentState) _mute.isPressed = true;
}

void OpenXrView::Inside::end()
{
    OpenXrLending::one().lend(nullptr);
    if (!_instance) return;
    for (Pictures& eye : _eyes)
        for (Swapchain* chain : {&eye.color, &eye.depth})
        {
            if (chain->handle != XR_NULL_HANDLE) _xr->destroySwapchain(chain->handle);
            *chain = {};
        }
    if (_room.layer != XR_NULL_HANDLE) _xr->destroyRoom(_room.layer);
    if (_room.passthrough != XR_NULL_HANDLE) _xr->destroyPassthrough(_room.passthrough);
    _room = {};
    if (_mute.set != XR_NULL_HANDLE) _xr->destroySet(_mute.set);
    _mute = {};
    _frame = {};
    _session.reset();
    _xr.reset();
    _instance.reset(); // the next one may be another runtime's
}

/// Like OpenXrInstance::check(), and stores whether the session may come back.
void OpenXrView::Inside::check(XrResult result, const char* call)
{
    try
    {
        _instance->check(result, call);
    }
    catch (const OpenXrError& error)
    {
        _mayReturn = error.mayPass();
        throw;
    }
}

bool OpenXrView::Inside::wait()
{
    try
    {
        _session->handleEvents();
        if (!_session->isRunning()) return false;
        readMuteButton();
        _frame.state = typed<XrFrameState>(XR_TYPE_FRAME_STATE);
        const auto info = typed<XrFrameWaitInfo>(XR_TYPE_FRAME_WAIT_INFO);
        check(_xr->waitFrame(_session->handle(), &info, &_frame.state), "xrWaitFrame");
        const XrTime time = _frame.state.predictedDisplayTime;
        OpenXrLending::one().use(
            [this, time](OpenXrSession& session)
            {
                HandFrame shown;
                session.setTime(time);
                session.anchor(_anchor, time);
                session.locateAt(time, shown);
                OpenXrLending::one().show(shown);
            });
    }
    catch (const OpenXrError& error)
    {
        _mayReturn = error.mayPass();
        throw;
    }
    _frame.isLocated = false;
    return true;
}

bool OpenXrView::Inside::locate(OpenXrEyes& eyes)
{
    _frame.isLocated = false;
    if (!_frame.state.shouldRender) return false;
    auto info = typed<XrViewLocateInfo>(XR_TYPE_VIEW_LOCATE_INFO);
    info.viewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
    info.displayTime = _frame.state.predictedDisplayTime;
    info.space = _session->space();
    auto state = typed<XrViewState>(XR_TYPE_VIEW_STATE);
    std::uint32_t count = 0;
    for (XrView& view : _frame.views)
        view = typed<XrView>(XR_TYPE_VIEW);
    check(_xr->locateViews(_session->handle(), &info, &state, 2, &count, _frame.views.data()),
          "xrLocateViews");
    constexpr XrViewStateFlags kKnown =
        XR_VIEW_STATE_ORIENTATION_VALID_BIT | XR_VIEW_STATE_POSITION_VALID_BIT;
    if (count != 2 || (state.viewStateFlags & kKnown) != kKnown) return false;
    for (std::size_t i = 0; i < eyes.size(); ++i)
    {
        const XrFovf& fov = _frame.views[i].fov;
        eyes[i].pose = poseOf(_frame.views[i].pose);
        eyes[i].left = std::tan(fov.angleLeft);
        eyes[i].right = std::tan(fov.angleRight);
        eyes[i].down = std::tan(fov.angleDown);
        eyes[i].up = std::tan(fov.angleUp);
        // Also false for NaN.
        if (!eyes[i].pose.matrix().allFinite() || !(eyes[i].right > eyes[i].left) ||
            !(eyes[i].up > eyes[i].down))
            return false;
    }
    return _frame.isLocated = true;
}

void OpenXrView::Inside::beginFrame()
{
    const auto info = typed<XrFrameBeginInfo>(XR_TYPE_FRAME_BEGIN_INFO);
    check(_xr->beginFrame(_session->handle(), &info), "xrBeginFrame");
    _frame.isBegun = true;
    for (Pictures& eye : _eyes)
        eye.color.isDrawn = eye.depth.isDrawn = false;
}

std::uint32_t OpenXrView::Inside::acquire(Swapchain& chain)
{
    if (chain.handle == XR_NULL_HANDLE) return 0;
    std::uint32_t index = 0;
    const auto info = typed<XrSwapchainImageAcquireInfo>(XR_TYPE_SWAPCHAIN_IMAGE_ACQUIRE_INFO);
    check(_xr->acquire(chain.handle, &info, &index), "xrAcquireSwapchainImage");
    chain.isHeld = true;
    auto wait = typed<XrSwapchainImageWaitInfo>(XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO);
    wait.timeout = XR_INFINITE_DURATION;
    check(_xr->waitImage(chain.handle, &wait), "xrWaitSwapchainImage");
    chain.isDrawn = true;
    return index < chain.images.size() ? chain.images[index].image : 0;
}

void OpenXrView::Inside::release(Swapchain& chain)
{
    if (!std::exchange(chain.isHeld, false)) return;
    const auto info = typed<XrSwapchainImageReleaseInfo>(XR_TYPE_SWAPCHAIN_IMAGE_RELEASE_INFO);
    check(_xr->release(chain.handle, &info), "xrReleaseSwapchainImage");
}

void OpenXrView::Inside::endFrame(double near_m, double far_m)
{
    if (!std::exchange(_frame.isBegun, false)) return;
    std::array<XrCompositionLayerProjectionView, 2> views{};
    std::array<XrCompositionLayerDepthInfoKHR, 2> depths{};
    bool isDrawn = _frame.isLocated;
    for (std::size_t i = 0; i < views.size(); ++i)
    {
        Pictures& eye = _eyes[i];
        release(eye.color);
        release(eye.depth);
        isDrawn = isDrawn && eye.color.isDrawn;
        const XrRect2Di whole = {{0, 0},
                                 {static_cast<std::int32_t>(eye.size.recommendedImageRectWidth),
                                  static_cast<std::int32_t>(eye.size.recommendedImageRectHeight)}};
        views[i].type = XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW;
        views[i].pose = _frame.views[i].pose;
        views[i].fov = _frame.views[i].fov;
        views[i].subImage = {eye.color.handle, whole, 0};
        if (!eye.depth.isDrawn) continue;
        depths[i].type = XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR;
        depths[i].subImage = {eye.depth.handle, whole, 0};
        depths[i].maxDepth = 1.0F;
        depths[i].nearZ = static_cast<float>(near_m);
        depths[i].farZ = static_cast<float>(far_m);
        views[i].next = &depths[i];
    }
    auto room = typed<XrCompositionLayerPassthroughFB>(XR_TYPE_COMPOSITION_LAYER_PASSTHROUGH_FB);
    room.flags = XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT;
    room.layerHandle = _room.layer;
    auto drawn = typed<XrCompositionLayerProjection>(XR_TYPE_COMPOSITION_LAYER_PROJECTION);
    if (_room.blend == OpenXrBlend::ALPHA)
        drawn.layerFlags = XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT;
    drawn.space = _session->space();
    drawn.viewCount = static_cast<std::uint32_t>(views.size());
    drawn.views = views.data();
    std::vector<const XrCompositionLayerBaseHeader*> layers;
    if (isDrawn && _room.layer != XR_NULL_HANDLE)
        layers.push_back(reinterpret_cast<const XrCompositionLayerBaseHeader*>(&room));
    if (isDrawn) layers.push_back(reinterpret_cast<const XrCompositionLayerBaseHeader*>(&drawn));
    auto info = typed<XrFrameEndInfo>(XR_TYPE_FRAME_END_INFO);
    info.displayTime = _frame.state.predictedDisplayTime;
    info.environmentBlendMode = _room.mode;
    info.layerCount = static_cast<std::uint32_t>(layers.size());
    info.layers = layers.data();
    check(_xr->endFrame(_session->handle(), &info), "xrEndFrame");
}

OpenXrView::OpenXrView(const OpenXrOptions& options, const Eigen::Isometry3d& anchor) :
    _inside(std::make_unique<Inside>(options, anchor))
{
}

OpenXrView::~OpenXrView() = default;

void OpenXrView::begin(const OpenXrGraphics& graphics)
{
    _inside->begin(graphics);
}

void OpenXrView::end()
{
    _inside->end();
}

bool OpenXrView::hasSession() const
{
    return _inside->hasSession();
}

bool OpenXrView::wait()
{
    return _inside->wait();
}

bool OpenXrView::mayReturn() const
{
    return _inside->mayReturn();
}

std::optional<double> OpenXrView::displayTime() const
{
    return _inside->displayTime();
}

bool OpenXrView::locate(OpenXrEyes& eyes)
{
    return _inside->locate(eyes);
}

void OpenXrView::beginFrame()
{
    _inside->beginFrame();
}

std::uint32_t OpenXrView::picture(int eye)
{
    return _inside->acquire(_inside->eye(eye).color);
}

std::uint32_t OpenXrView::depth(int eye)
{
    return _inside->acquire(_inside->eye(eye).depth);
}

void OpenXrView::endFrame(double near_m, double far_m)
{
    _inside->endFrame(near_m, far_m);
}

int OpenXrView::width(int eye) const
{
    return static_cast<int>(_inside->eye(eye).size.recommendedImageRectWidth);
}

int OpenXrView::height(int eye) const
{
    return static_cast<int>(_inside->eye(eye).size.recommendedImageRectHeight);
}

int OpenXrView::depthFormat() const
{
    return static_cast<int>(_inside->depthFormat());
}

OpenXrBlend OpenXrView::blend() const
{
    return _inside->blend();
}

bool OpenXrView::takeMute()
{
    return _inside->takeMute();
}

std::string OpenXrView::runtime() const
{
    return _inside->runtime();
}

std::string OpenXrView::status() const
{
    return "headset of " + _inside->runtime() +
           (!_inside->hasSession() ? ", without a session"
            : _inside->isRunning() ? ""
                                   : ", idle");
}

std::vector<std::string> OpenXrView::messages(std::size_t& told) const
{
    return OpenXrLending::one().messages(told);
}

} // namespace midair::bridge
