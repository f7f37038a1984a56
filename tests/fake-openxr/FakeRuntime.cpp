#define XR_USE_GRAPHICS_API_OPENGL
// An OpenXR runtime without a headset, for Debian's loader: the test that links this library shares
// its state with the runtime, since the loader gets the same library.
#include "tests/fake-openxr/FakeRuntime.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <thread>
#include <utility>

#include <dlfcn.h>
#include <openxr/openxr_platform.h>

namespace
{

std::mutex gMutex;
std::condition_variable gChanged;
FakeState gState;

// Handles are numbers of their own kind; what isn't known isn't valid.
constexpr std::uintptr_t kInstance = 1;
constexpr std::uintptr_t kSession = 2;
constexpr std::uintptr_t kSpace = 3;
constexpr std::uintptr_t kLeft = 4;
constexpr std::uintptr_t kRight = 5;
constexpr std::uintptr_t kView = 6;
constexpr std::uintptr_t kAnchored = 7; ///< a space
constexpr std::uintptr_t kAnchor = 8;

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

    bool isWhole() const { return display && visual && config && drawable && context; }
};

struct FakeSwapchain
{
    int width = 0;
    int height = 0;
    bool isDepth = false;
    std::vector<std::uint32_t> textures;
    std::size_t next = 0;
    int held = -1; ///< the image that is acquired
    bool isWaited = false;
    int last = -1; ///< that was released last
};

struct FakeFrame
{
    bool isWaited = false;
    bool isBegun = false;
    XrTime display = 0;
    double next_s = 0.0; ///< when a paced one comes
};

bool gIsAsked = false; ///< the requirements of graphics were asked for
std::map<std::uintptr_t, FakeSwapchain> gChains;
std::uintptr_t gLastHandle = 100;
FakeFrame gFrame;
bool gWasPressed = false;
XrSessionState gSession = XR_SESSION_STATE_UNKNOWN;
bool gRunning = false;
bool gHeadless = false;
bool gGraphics = false;
XrTime gTime = 0;                   // as last converted
std::array<FakeHand, 2> gLast = {}; // left, right
XrPosef gAnchored{};                // of the anchor

template<typename H>
H handle(std::uintptr_t number)
{
    return reinterpret_cast<H>(number);
}

Eigen::Isometry3d isometryOf(const XrPosef& pose)
{
    const XrVector3f& p = pose.position;
    const XrQuaternionf& q = pose.orientation;
    return Eigen::Translation3d(p.x, p.y, p.z) * Eigen::Quaterniond(q.w, q.x, q.y, q.z);
}

/// True, with what to return, where the test wants \a function to fail; waits where it is to hang.
bool fails(FakeAccess& state, const char* function, XrResult& result)
{
    state.waitWhileBlocked(function);
    const auto found = state->failures.find(function);
    if (found == state->failures.end()) return false;
    result = found->second;
    return true;
}

/// In another process than the test's nobody sets a hand: the variable MIDAIR_FAKE_HAND=right does.
std::optional<FakeHand> handOfEnvironment(std::size_t which)
{
    const char* named = std::getenv("MIDAIR_FAKE_HAND");
    if (!named || std::strcmp(named, "right") != 0 || which != 1) return std::nullopt;
    FakeHand hand{};
    for (std::size_t i = 0; i < hand.size(); ++i)
    {
        hand[i].pose = {{0, 0, 0, 1}, {0.01F * static_cast<float>(i), 0.2F, 0}};
        hand[i].radius = 0.008F;
        hand[i].locationFlags =
            XR_SPACE_LOCATION_POSITION_VALID_BIT | XR_SPACE_LOCATION_ORIENTATION_VALID_BIT;
    }
    return hand;
}

/// \a pose of what moves, at \a time.
XrPosef moved(const FakeState& state, XrPosef pose, XrTime time)
{
    const XrVector3f sway = state.swayAt(time);
    pose.position.x += sway.x;
    pose.position.y += sway.y;
    pose.position.z += sway.z;
    return pose;
}

/// \a pose as it is in \a base; \a isBack: as it is there to the room. Returns false for no space.
bool inBase(const FakeState& state, XrSpace base, XrPosef& pose, bool isBack = false)
{
    if (base == handle<XrSpace>(kAnchored)) return true;
    const float sign = isBack ? 1.0F : -1.0F;
    pose.position.x += sign * state.spaceMoved.x;
    pose.position.y += sign * state.spaceMoved.y;
    pose.position.z += sign * state.spaceMoved.z;
    return base == handle<XrSpace>(kSpace);
}

void expect(FakeAccess& state, bool right, const char* what)
{
    if (!right) state->misuse.emplace_back(what);
}

XrResult enumerateExtensions(const char*,
                             std::uint32_t capacity,
                             std::uint32_t* count,
                             XrExtensionProperties* properties)
{
    FakeAccess state;
    *count = static_cast<std::uint32_t>(state->extensions.size());
    for (std::uint32_t i = 0; i < std::min(capacity, *count); ++i)
        std::snprintf(properties[i].extensionName,
                      sizeof properties[i].extensionName,
                      "%s",
                      state->extensions[i].c_str());
    return XR_SUCCESS;
}

XrResult createInstance(const XrInstanceCreateInfo* info, XrInstance* instance)
{
    FakeAccess state;
    XrResult result = XR_SUCCESS;
    if (fails(state, "xrCreateInstance", result)) return result;
    gHeadless = gGraphics = false;
    for (std::uint32_t i = 0; i < info->enabledExtensionCount; ++i)
    {
        const std::string name = info->enabledExtensionNames[i];
        if (std::count(state->extensions.begin(), state->extensions.end(), name) == 0)
            return XR_ERROR_EXTENSION_NOT_PRESENT;
        gHeadless = gHeadless || name == "XR_MND_headless";
        gGraphics = gGraphics || name == "XR_KHR_opengl_enable";
    }
    ++state->instances;
    ++state->alive;
    *instance = handle<XrInstance>(kInstance);
    return XR_SUCCESS;
}

XrResult destroyInstance(XrInstance)
{
    FakeAccess state;
    --state->alive;
    expect(state, state->alive == 0, "the instance went before its children");
    return XR_SUCCESS;
}

XrResult getInstanceProperties(XrInstance, XrInstanceProperties* properties)
{
    properties->runtimeVersion = XR_MAKE_VERSION(1, 2, 3);
    std::strcpy(properties->runtimeName, "Fake XR");
    return XR_SUCCESS;
}

XrResult getSystem(XrInstance, const XrSystemGetInfo*, XrSystemId* system)
{
    FakeAccess state;
    XrResult result = XR_SUCCESS;
    if (fails(state, "xrGetSystem", result)) return result;
    *system = 1;
    return XR_SUCCESS;
}

XrResult getSystemProperties(XrInstance, XrSystemId, XrSystemProperties* properties)
{
    FakeAccess state;
    std::strcpy(properties->systemName, "Fake headset");
    auto* tracking = static_cast<XrSystemHandTrackingPropertiesEXT*>(properties->next);
    if (tracking && tracking->type == XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT)
        tracking->supportsHandTracking = state->tracksHands ? XR_TRUE : XR_FALSE;
    auto* room = static_cast<XrSystemPassthroughPropertiesFB*>(properties->next);
    if (room && room->type == XR_TYPE_SYSTEM_PASSTHROUGH_PROPERTIES_FB)
        room->supportsPassthrough = state->hasPassthrough ? XR_TRUE : XR_FALSE;
    return XR_SUCCESS;
}

XrResult pollEvent(XrInstance, XrEventDataBuffer* buffer)
{
    FakeAccess state;
    XrResult result = XR_SUCCESS;
    if (fails(state, "xrPollEvent", result)) return result;
    if (state->otherEvent != XR_TYPE_UNKNOWN)
    {
        XrEventDataReferenceSpaceChangePending event{};
        event.type = state->otherEvent;
        event.session = handle<XrSession>(kSession);
        event.referenceSpaceType = state->space;
        std::memcpy(buffer, &event, sizeof event);
        state->otherEvent = XR_TYPE_UNKNOWN;
        return XR_SUCCESS;
    }
    if (state->states.empty() || gSession == XR_SESSION_STATE_UNKNOWN) return XR_EVENT_UNAVAILABLE;
    gSession = state->states.front();
    state->states.pop_front();
    XrEventDataSessionStateChanged event{};
    event.type = XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED;
    event.session = handle<XrSession>(kSession);
    event.state = gSession;
    std::memcpy(buffer, &event, sizeof event);
    return XR_SUCCESS;
}

XrResult createSession(XrInstance, const XrSessionCreateInfo* info, XrSession* session)
{
    FakeAccess state;
    XrResult result = XR_SUCCESS;
    if (fails(state, "xrCreateSession", result)) return result;
    if (info->systemId != 1) return XR_ERROR_SYSTEM_INVALID;
    const auto* binding = static_cast<const XrBaseInStructure*>(info->next);
    const bool isDrawn = gGraphics && binding &&
                         binding->type == XR_TYPE_GRAPHICS_BINDING_OPENGL_XLIB_KHR &&
                         static_cast<const XlibBinding*>(info->next)->isWhole();
    if (!gHeadless && !isDrawn) return XR_ERROR_GRAPHICS_DEVICE_INVALID;
    if (gGraphics) expect(state, gIsAsked, "the requirements of graphics were not asked for");
    gFrame = {};
    gSession = XR_SESSION_STATE_IDLE;
    gLast = {};
    gRunning = false;
    state->states.push_front(XR_SESSION_STATE_READY);
    ++state->alive;
    *session = handle<XrSession>(kSession);
    return XR_SUCCESS;
}

XrResult destroySession(XrSession)
{
    FakeAccess state;
    gSession = XR_SESSION_STATE_UNKNOWN;
    state->states.clear();
    --state->alive;
    return XR_SUCCESS;
}

XrResult beginSession(XrSession, const XrSessionBeginInfo*)
{
    FakeAccess state;
    expect(state, gSession == XR_SESSION_STATE_READY, "a session began that wasn't ready");
    gRunning = true;
    ++state->begun;
    if (gGraphics)
        for (const XrSessionState next :
             {XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_VISIBLE, XR_SESSION_STATE_FOCUSED})
            state->states.push_back(next);
    return XR_SUCCESS;
}

XrResult endSession(XrSession)
{
    FakeAccess state;
    expect(state, gSession == XR_SESSION_STATE_STOPPING, "a session ended that wasn't stopping");
    gRunning = false;
    ++state->ended;
    return XR_SUCCESS;
}

XrResult enumerateSpaces(XrSession,
                         std::uint32_t capacity,
                         std::uint32_t* count,
                         XrReferenceSpaceType* spaces)
{
    FakeAccess state;
    *count = static_cast<std::uint32_t>(state->spaces.size());
    for (std::uint32_t i = 0; i < std::min(capacity, *count); ++i)
        spaces[i] = state->spaces[i];
    return XR_SUCCESS;
}

XrResult createSpace(XrSession, const XrReferenceSpaceCreateInfo* info, XrSpace* space)
{
    FakeAccess state;
    const XrQuaternionf& turn = info->poseInReferenceSpace.orientation;
    if (turn.x != 0.0f || turn.y != 0.0f || turn.z != 0.0f || turn.w != 1.0f)
        return XR_ERROR_POSE_INVALID;
    const bool isView = info->referenceSpaceType == XR_REFERENCE_SPACE_TYPE_VIEW;
    if (!isView) state->space = info->referenceSpaceType;
    ++state->alive;
    *space = handle<XrSpace>(isView ? kView : kSpace);
    return XR_SUCCESS;
}

XrResult
createAnchor(XrSession, const XrSpatialAnchorCreateInfoMSFT* info, XrSpatialAnchorMSFT* anchor)
{
    FakeAccess state;
    if (info->space != handle<XrSpace>(kSpace)) return XR_ERROR_HANDLE_INVALID;
    if (state->anchorsRefused-- > 0) return XR_ERROR_CREATE_SPATIAL_ANCHOR_FAILED_MSFT;
    ++state->alive;
    gAnchored = info->pose;
    *anchor = handle<XrSpatialAnchorMSFT>(kAnchor);
    return XR_SUCCESS;
}

/// Of the space that was anchored, and no other.
XrResult
createAnchorSpace(XrSession, const XrSpatialAnchorSpaceCreateInfoMSFT* info, XrSpace* space)
{
    FakeAccess state;
    const Eigen::Isometry3d both = isometryOf(gAnchored) * isometryOf(info->poseInAnchorSpace);
    if (info->anchor != handle<XrSpatialAnchorMSFT>(kAnchor) ||
        !both.isApprox(Eigen::Isometry3d::Identity(), 1e-5))
        return XR_ERROR_POSE_INVALID;
    ++state->alive;
    *space = handle<XrSpace>(kAnchored);
    return XR_SUCCESS;
}

XrResult destroySpace(XrSpace)
{
    FakeAccess state;
    --state->alive;
    return XR_SUCCESS;
}

XrResult locateSpace(XrSpace space, XrSpace base, XrTime time, XrSpaceLocation* location)
{
    FakeAccess state;
    XrResult result = XR_SUCCESS;
    if (fails(state, "xrLocateSpace", result)) return result;
    expect(state, gRunning, "a head was located of a session that doesn't run");
    location->pose = moved(*state, state->head.value_or(XrPosef{{0, 0, 0, 1}, {0, 0, 0}}), time);
    if (space != handle<XrSpace>(kView) || !inBase(*state, base, location->pose))
        return XR_ERROR_HANDLE_INVALID;
    if (time < gTime || time > gTime + 1000000000) return XR_ERROR_TIME_INVALID;
    if (time > gTime && !state->predicts) return XR_ERROR_TIME_INVALID;
    state->headAhead = time - gTime;
    // One that is lost is where the runtime thinks that it is.
    location->locationFlags =
        XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT;
    if (state->head) location->locationFlags |= XR_SPACE_LOCATION_POSITION_TRACKED_BIT;
    ++state->headsLocated;
    return XR_SUCCESS;
}

XrResult convertTime(XrInstance, const timespec* from, XrTime* time)
{
    FakeAccess state;
    gTime = static_cast<XrTime>(from->tv_sec) * 1000000000 + from->tv_nsec;
    *time = gTime;
    return XR_SUCCESS;
}

XrResult
createHandTracker(XrSession, const XrHandTrackerCreateInfoEXT* info, XrHandTrackerEXT* tracker)
{
    FakeAccess state;
    XrResult result = XR_SUCCESS;
    if (fails(state, "xrCreateHandTrackerEXT", result)) return result;
    ++state->alive;
    *tracker = handle<XrHandTrackerEXT>(info->hand == XR_HAND_LEFT_EXT ? kLeft : kRight);
    return XR_SUCCESS;
}

XrResult destroyHandTracker(XrHandTrackerEXT)
{
    FakeAccess state;
    --state->alive;
    return XR_SUCCESS;
}

XrResult locateHandJoints(XrHandTrackerEXT tracker,
                          const XrHandJointsLocateInfoEXT* info,
                          XrHandJointLocationsEXT* locations)
{
    FakeAccess state;
    XrResult result = XR_SUCCESS;
    if (fails(state, "xrLocateHandJointsEXT", result)) return result;
    expect(state, gRunning, "hands were located of a session that doesn't run");
    XrPosef none{};
    if (!inBase(*state, info->baseSpace, none)) return XR_ERROR_HANDLE_INVALID;
    // Nobody asks for the past, or for what no runtime can know.
    if (info->time < gTime || info->time > gTime + 1000000000) return XR_ERROR_TIME_INVALID;
    if (info->time > gTime && !state->predicts) return XR_ERROR_TIME_INVALID;
    state->ahead = info->time - gTime;
    if (locations->jointCount != XR_HAND_JOINT_COUNT_EXT) return XR_ERROR_VALIDATION_FAILURE;
    const std::size_t which = tracker == handle<XrHandTrackerEXT>(kRight) ? 1 : 0;
    const std::optional<FakeHand> hand =
        state->hands[which] ? state->hands[which] : handOfEnvironment(which);
    locations->isActive = hand ? XR_TRUE : XR_FALSE;
    // A hand that is lost leaves where it last was, as if it were there.
    if (hand) gLast[which] = *hand;
    std::copy(gLast[which].begin(), gLast[which].end(), locations->jointLocations);
    for (std::size_t i = 0; i < gLast[which].size(); ++i)
    {
        locations->jointLocations[i].pose = moved(*state, gLast[which][i].pose, info->time);
        inBase(*state, info->baseSpace, locations->jointLocations[i].pose);
    }
    ++state->located;
    return XR_SUCCESS;
}

// --- Pictures ------------------------------------------------------------------------------------

constexpr unsigned int kTexture2D = 0x0DE1;
constexpr unsigned int kRgba = 0x1908;
constexpr unsigned int kDepth = 0x1902;
constexpr unsigned int kByte = 0x1401;
constexpr unsigned int kFloat = 0x1406;
constexpr std::int64_t kSrgb = 0x8C43;
constexpr std::int64_t kDepth24 = 0x81A6;

/// A function of the OpenGL of the program.
template<typename F>
F gl(const char* name)
{
    void* found = dlsym(RTLD_DEFAULT, name);
    if (!found) found = dlsym(dlopen("libGL.so.1", RTLD_NOW), name);
    return reinterpret_cast<F>(found);
}

void bindTexture(std::uint32_t texture)
{
    gl<void (*)(unsigned int, unsigned int)>("glBindTexture")(kTexture2D, texture);
}

std::uint32_t makeTexture(const FakeSwapchain& chain, std::int64_t format)
{
    std::uint32_t texture = 0;
    gl<void (*)(int, std::uint32_t*)>("glGenTextures")(1, &texture);
    bindTexture(texture);
    gl<void (*)(unsigned int, int, int, int, int, int, unsigned int, unsigned int, const void*)>(
        "glTexImage2D")(kTexture2D,
                        0,
                        static_cast<int>(format),
                        chain.width,
                        chain.height,
                        0,
                        chain.isDepth ? kDepth : kRgba,
                        chain.isDepth ? kFloat : kByte,
                        nullptr);
    constexpr unsigned int kMinFilter = 0x2801;
    constexpr int kLinear = 0x2601;
    gl<void (*)(unsigned int, unsigned int, int)>("glTexParameteri")(
        kTexture2D, kMinFilter, kLinear);
    bindTexture(0);
    return texture;
}

void readTexture(std::uint32_t texture, bool isDepth, void* to)
{
    bindTexture(texture);
    gl<void (*)(unsigned int, int, unsigned int, unsigned int, void*)>("glGetTexImage")(
        kTexture2D, 0, isDepth ? kDepth : kRgba, isDepth ? kFloat : kByte, to);
    bindTexture(0);
}

XrResult enumerateViews(XrInstance,
                        XrSystemId,
                        XrViewConfigurationType,
                        std::uint32_t capacity,
                        std::uint32_t* count,
                        XrViewConfigurationView* views)
{
    FakeAccess state;
    *count = 2;
    for (std::uint32_t i = 0; i < std::min(capacity, *count); ++i)
    {
        views[i].recommendedImageRectWidth = views[i].maxImageRectWidth =
            static_cast<std::uint32_t>(state->width);
        views[i].recommendedImageRectHeight = views[i].maxImageRectHeight =
            static_cast<std::uint32_t>(state->height);
        views[i].recommendedSwapchainSampleCount = views[i].maxSwapchainSampleCount = 1;
    }
    return XR_SUCCESS;
}

XrResult enumerateBlendModes(XrInstance,
                             XrSystemId,
                             XrViewConfigurationType,
                             std::uint32_t capacity,
                             std::uint32_t* count,
                             XrEnvironmentBlendMode* modes)
{
    FakeAccess state;
    *count = static_cast<std::uint32_t>(state->blendModes.size());
    for (std::uint32_t i = 0; i < std::min(capacity, *count); ++i)
        modes[i] = state->blendModes[i];
    return XR_SUCCESS;
}

XrResult requirements(XrInstance, XrSystemId, XrGraphicsRequirementsOpenGLKHR* needed)
{
    gIsAsked = true;
    needed->minApiVersionSupported = XR_MAKE_VERSION(2, 0, 0);
    needed->maxApiVersionSupported = XR_MAKE_VERSION(4, 6, 0);
    return XR_SUCCESS;
}

XrResult
enumerateFormats(XrSession, std::uint32_t capacity, std::uint32_t* count, std::int64_t* formats)
{
    const std::array<std::int64_t, 2> all = {kSrgb, kDepth24};
    *count = static_cast<std::uint32_t>(all.size());
    for (std::uint32_t i = 0; i < std::min(capacity, *count); ++i)
        formats[i] = all[i];
    return XR_SUCCESS;
}

XrResult createSwapchain(XrSession, const XrSwapchainCreateInfo* info, XrSwapchain* swapchain)
{
    FakeAccess state;
    FakeSwapchain chain;
    chain.width = static_cast<int>(info->width);
    chain.height = static_cast<int>(info->height);
    chain.isDepth = info->format == kDepth24;
    if (info->format != kSrgb && info->format != kDepth24)
        return XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED;
    for (int i = 0; i < 3; ++i)
        chain.textures.push_back(makeTexture(chain, info->format));
    ++state->alive;
    gChains[++gLastHandle] = chain;
    *swapchain = handle<XrSwapchain>(gLastHandle);
    return XR_SUCCESS;
}

FakeSwapchain* chainOf(XrSwapchain swapchain)
{
    const auto found = gChains.find(reinterpret_cast<std::uintptr_t>(swapchain));
    return found == gChains.end() ? nullptr : &found->second;
}

XrResult destroySwapchain(XrSwapchain swapchain)
{
    FakeAccess state;
    FakeSwapchain* chain = chainOf(swapchain);
    if (!chain) return XR_ERROR_HANDLE_INVALID;
    gl<void (*)(int, const std::uint32_t*)>("glDeleteTextures")(
        static_cast<int>(chain->textures.size()), chain->textures.data());
    gChains.erase(reinterpret_cast<std::uintptr_t>(swapchain));
    --state->alive;
    return XR_SUCCESS;
}

XrResult enumerateImages(XrSwapchain swapchain,
                         std::uint32_t capacity,
                         std::uint32_t* count,
                         XrSwapchainImageBaseHeader* images)
{
    FakeAccess state;
    FakeSwapchain* chain = chainOf(swapchain);
    if (!chain) return XR_ERROR_HANDLE_INVALID;
    *count = static_cast<std::uint32_t>(chain->textures.size());
    auto* all = reinterpret_cast<XrSwapchainImageOpenGLKHR*>(images);
    for (std::uint32_t i = 0; i < std::min(capacity, *count); ++i)
        all[i].image = chain->textures[i];
    return XR_SUCCESS;
}

XrResult
acquireImage(XrSwapchain swapchain, const XrSwapchainImageAcquireInfo*, std::uint32_t* index)
{
    FakeAccess state;
    FakeSwapchain* chain = chainOf(swapchain);
    if (!chain) return XR_ERROR_HANDLE_INVALID;
    expect(state, chain->held < 0, "an image was acquired before the one before was released");
    chain->held = static_cast<int>(chain->next);
    chain->next = (chain->next + 1) % chain->textures.size();
    chain->isWaited = false;
    *index = static_cast<std::uint32_t>(chain->held);
    return XR_SUCCESS;
}

XrResult waitImage(XrSwapchain swapchain, const XrSwapchainImageWaitInfo*)
{
    FakeAccess state;
    FakeSwapchain* chain = chainOf(swapchain);
    if (!chain) return XR_ERROR_HANDLE_INVALID;
    if (chain->held < 0) return XR_ERROR_CALL_ORDER_INVALID;
    chain->isWaited = true;
    return XR_SUCCESS;
}

XrResult releaseImage(XrSwapchain swapchain, const XrSwapchainImageReleaseInfo*)
{
    FakeAccess state;
    FakeSwapchain* chain = chainOf(swapchain);
    if (!chain) return XR_ERROR_HANDLE_INVALID;
    expect(state, chain->isWaited, "an image was released that was not waited for");
    if (!chain->isWaited || chain->held < 0) return XR_ERROR_CALL_ORDER_INVALID;
    chain->last = std::exchange(chain->held, -1);
    return XR_SUCCESS;
}

XrResult waitFrame(XrSession, const XrFrameWaitInfo*, XrFrameState* frame)
{
    constexpr double kPeriod_s = 1.0 / 90.0;
    constexpr XrDuration kAhead = 22000000;
    double next_s = 0.0;
    {
        FakeAccess state;
        XrResult result = XR_SUCCESS;
        if (fails(state, "xrWaitFrame", result)) return result;
        expect(state, gRunning, "a frame was waited for of a session that doesn't run");
        expect(state, !gFrame.isWaited, "a frame was waited for before the one before was begun");
        const double now_s = 1e-9 * static_cast<double>(FakeState::now());
        if (state->isPaced) next_s = gFrame.next_s = std::max(now_s, gFrame.next_s + kPeriod_s);
    }
    const double left_s = next_s - 1e-9 * static_cast<double>(FakeState::now());
    if (left_s > 0.0) std::this_thread::sleep_for(std::chrono::duration<double>(left_s));
    FakeAccess state;
    gFrame.isWaited = true;
    gTime = FakeState::now();
    gFrame.display = gTime + kAhead;
    frame->predictedDisplayTime = gFrame.display;
    frame->predictedDisplayPeriod = 11111111;
    frame->shouldRender =
        gSession == XR_SESSION_STATE_VISIBLE || gSession == XR_SESSION_STATE_FOCUSED;
    return XR_SUCCESS;
}

XrResult beginFrame(XrSession, const XrFrameBeginInfo*)
{
    FakeAccess state;
    XrResult result = XR_SUCCESS;
    if (fails(state, "xrBeginFrame", result)) return result;
    expect(state, gFrame.isWaited, "a frame was begun that was not waited for");
    gFrame.isWaited = false;
    gFrame.isBegun = true;
    return XR_SUCCESS;
}

XrResult locateViews(XrSession,
                     const XrViewLocateInfo* info,
                     XrViewState* viewState,
                     std::uint32_t capacity,
                     std::uint32_t* count,
                     XrView* views)
{
    FakeAccess state;
    XrResult result = XR_SUCCESS;
    if (fails(state, "xrLocateViews", result)) return result;
    *count = 2;
    viewState->viewStateFlags =
        state->head ? XR_VIEW_STATE_ORIENTATION_VALID_BIT | XR_VIEW_STATE_POSITION_VALID_BIT : 0;
    for (std::uint32_t i = 0; i < std::min(capacity, *count); ++i)
    {
        views[i].pose = state->eyeAt(static_cast<int>(i), info->displayTime);
        views[i].fov = FakeState::fovOf(static_cast<int>(i));
        if (!inBase(*state, info->space, views[i].pose)) return XR_ERROR_HANDLE_INVALID;
    }
    return XR_SUCCESS;
}

/// What the eye is shown by \a view, whose pose is in \a space, at \a time.
void show(FakeAccess& state,
          int eye,
          const XrCompositionLayerProjectionView& view,
          XrSpace space,
          XrTime time)
{
    FakePicture& picture = state->pictures[static_cast<std::size_t>(eye)];
    const FakeSwapchain* chain = chainOf(view.subImage.swapchain);
    expect(state, chain && chain->last >= 0 && chain->held < 0, "a picture was not released");
    if (!chain || chain->last < 0) return;
    picture.width = chain->width;
    picture.height = chain->height;
    picture.pose = view.pose;
    inBase(*state, space, picture.pose, true);
    picture.fov = view.fov;
    picture.truePose = state->eyeAt(eye, time);
    const XrVector3f& a = picture.pose.position;
    const XrVector3f& b = picture.truePose.position;
    picture.off_m = std::hypot(a.x - b.x, std::hypot(a.y - b.y, a.z - b.z));
    const XrQuaternionf& p = picture.pose.orientation;
    const XrQuaternionf& q = picture.truePose.orientation;
    const double cosine = std::abs(p.x * q.x + p.y * q.y + p.z * q.z + p.w * q.w);
    picture.off_rad = 2.0 * std::acos(std::min(1.0, cosine));
    state->largestOff_m = std::max(state->largestOff_m, picture.off_m);
    if (!state->keepsPictures) return;
    const auto size = static_cast<std::size_t>(chain->width * chain->height);
    picture.rgba.resize(4 * size);
    readTexture(chain->textures[static_cast<std::size_t>(chain->last)], false, picture.rgba.data());
    picture.depth.clear();
    const auto* depth = static_cast<const XrCompositionLayerDepthInfoKHR*>(view.next);
    if (!depth) return;
    expect(state, depth->nearZ > 0.0F && depth->farZ > depth->nearZ, "clip planes of the depth");
    const FakeSwapchain* depths = chainOf(depth->subImage.swapchain);
    if (!depths || depths->last < 0) return;
    picture.depth.resize(size);
    readTexture(
        depths->textures[static_cast<std::size_t>(depths->last)], true, picture.depth.data());
}

XrResult endFrame(XrSession, const XrFrameEndInfo* info)
{
    FakeAccess state;
    XrResult result = XR_SUCCESS;
    if (fails(state, "xrEndFrame", result)) return result;
    expect(state, gFrame.isBegun, "a frame was ended that was not begun");
    expect(state, info->displayTime == gFrame.display, "a frame was ended of another time");
    gFrame.isBegun = false;
    ++state->frames;
    state->blend = info->environmentBlendMode;
    state->roomLayers = 0;
    for (std::uint32_t i = 0; i < info->layerCount; ++i)
    {
        const XrCompositionLayerBaseHeader& layer = *info->layers[i];
        if (layer.type == XR_TYPE_COMPOSITION_LAYER_PASSTHROUGH_FB) ++state->roomLayers;
        if (layer.type != XR_TYPE_COMPOSITION_LAYER_PROJECTION) continue;
        const auto& drawn = reinterpret_cast<const XrCompositionLayerProjection&>(layer);
        expect(state, drawn.viewCount == 2, "a layer has not two views");
        state->layerFlags = drawn.layerFlags;
        ++state->framesDrawn;
        for (int eye = 0; eye < 2; ++eye)
            show(state, eye, drawn.views[eye], drawn.space, info->displayTime);
    }
    return XR_SUCCESS;
}

// --- Controllers and passthrough -----------------------------------------------------------------

XrResult stringToPath(XrInstance, const char* text, XrPath* path)
{
    *path = std::hash<std::string>()(text) | 1U;
    return XR_SUCCESS;
}

template<typename Info, typename Parent, typename Handle>
XrResult createOther(Parent, const Info*, Handle* made)
{
    FakeAccess state;
    ++state->alive;
    *made = handle<Handle>(++gLastHandle);
    return XR_SUCCESS;
}

template<typename Handle>
XrResult destroyOther(Handle)
{
    FakeAccess state;
    --state->alive;
    return XR_SUCCESS;
}

/// Goes with its set.
XrResult createAction(XrActionSet, const XrActionCreateInfo*, XrAction* action)
{
    *action = handle<XrAction>(++gLastHandle);
    return XR_SUCCESS;
}

XrResult suggestBindings(XrInstance, const XrInteractionProfileSuggestedBinding*)
{
    return XR_SUCCESS;
}

XrResult attachSets(XrSession, const XrSessionActionSetsAttachInfo*)
{
    return XR_SUCCESS;
}

XrResult syncActions(XrSession, const XrActionsSyncInfo*)
{
    return gSession == XR_SESSION_STATE_FOCUSED ? XR_SUCCESS : XR_SESSION_NOT_FOCUSED;
}

XrResult getBoolean(XrSession, const XrActionStateGetInfo*, XrActionStateBoolean* button)
{
    FakeAccess state;
    button->isActive = XR_TRUE;
    button->currentState = state->isMutePressed ? XR_TRUE : XR_FALSE;
    button->changedSinceLastSync =
        std::exchange(gWasPressed, state->isMutePressed) != state->isMutePressed ? XR_TRUE
                                                                                 : XR_FALSE;
    return XR_SUCCESS;
}

using Functions = std::map<std::string, PFN_xrVoidFunction>;

#define FAKE(name, function)                                                                       \
    {                                                                                              \
        name, reinterpret_cast<PFN_xrVoidFunction>(function)                                       \
    }
const Functions& trackingFunctions()
{
    static const Functions all = {
        FAKE("xrEnumerateInstanceExtensionProperties", enumerateExtensions),
        FAKE("xrCreateInstance", createInstance),
        FAKE("xrDestroyInstance", destroyInstance),
        FAKE("xrGetInstanceProperties", getInstanceProperties),
        FAKE("xrGetSystem", getSystem),
        FAKE("xrGetSystemProperties", getSystemProperties),
        FAKE("xrPollEvent", pollEvent),
        FAKE("xrCreateSession", createSession),
        FAKE("xrDestroySession", destroySession),
        FAKE("xrBeginSession", beginSession),
        FAKE("xrEndSession", endSession),
        FAKE("xrEnumerateReferenceSpaces", enumerateSpaces),
        FAKE("xrCreateReferenceSpace", createSpace),
        FAKE("xrDestroySpace", destroySpace),
        FAKE("xrLocateSpace", locateSpace),
        FAKE("xrCreateSpatialAnchorMSFT", createAnchor),
        FAKE("xrCreateSpatialAnchorSpaceMSFT", createAnchorSpace),
        FAKE("xrDestroySpatialAnchorMSFT", destroyOther<XrSpatialAnchorMSFT>),
        FAKE("xrConvertTimespecTimeToTimeKHR", convertTime),
        FAKE("xrCreateHandTrackerEXT", createHandTracker),
        FAKE("xrDestroyHandTrackerEXT", destroyHandTracker),
        FAKE("xrLocateHandJointsEXT", locateHandJoints)};
    return all;
}

const Functions& pictureFunctions()
{
    static const Functions all = {
        FAKE("xrEnumerateViewConfigurationViews", enumerateViews),
        FAKE("xrEnumerateEnvironmentBlendModes", enumerateBlendModes),
        FAKE("xrGetOpenGLGraphicsRequirementsKHR", requirements),
        FAKE("xrEnumerateSwapchainFormats", enumerateFormats),
        FAKE("xrCreateSwapchain", createSwapchain),
        FAKE("xrDestroySwapchain", destroySwapchain),
        FAKE("xrEnumerateSwapchainImages", enumerateImages),
        FAKE("xrAcquireSwapchainImage", acquireImage),
        FAKE("xrWaitSwapchainImage", waitImage),
        FAKE("xrReleaseSwapchainImage", releaseImage),
        FAKE("xrWaitFrame", waitFrame),
        FAKE("xrBeginFrame", beginFrame),
        FAKE("xrEndFrame", endFrame),
        FAKE("xrLocateViews", locateViews),
        FAKE("xrStringToPath", stringToPath),
        FAKE("xrCreateActionSet", (createOther<XrActionSetCreateInfo, XrInstance, XrActionSet>)),
        FAKE("xrDestroyActionSet", destroyOther<XrActionSet>),
        FAKE("xrCreateAction", createAction),
        FAKE("xrSuggestInteractionProfileBindings", suggestBindings),
        FAKE("xrAttachSessionActionSets", attachSets),
        FAKE("xrSyncActions", syncActions),
        FAKE("xrGetActionStateBoolean", getBoolean),
        FAKE("xrCreatePassthroughFB",
             (createOther<XrPassthroughCreateInfoFB, XrSession, XrPassthroughFB>)),
        FAKE("xrDestroyPassthroughFB", destroyOther<XrPassthroughFB>),
        FAKE("xrCreatePassthroughLayerFB",
             (createOther<XrPassthroughLayerCreateInfoFB, XrSession, XrPassthroughLayerFB>)),
        FAKE("xrDestroyPassthroughLayerFB", destroyOther<XrPassthroughLayerFB>)};
    return all;
}
#undef FAKE

XrResult getInstanceProcAddr(XrInstance, const char* name, PFN_xrVoidFunction* function)
{
    *function = nullptr;
    if (std::strcmp(name, "xrGetInstanceProcAddr") == 0)
        *function = reinterpret_cast<PFN_xrVoidFunction>(getInstanceProcAddr);
    for (const Functions* all : {&trackingFunctions(), &pictureFunctions()})
        if (const auto found = all->find(name); found != all->end()) *function = found->second;
    return *function ? XR_SUCCESS : XR_ERROR_FUNCTION_UNSUPPORTED;
}

// The loader's interface to runtimes, which Debian's headers leave out.
enum LoaderStruct
{
    LOADER_INFO = 1,
    RUNTIME_REQUEST = 3
};
struct LoaderInfo
{
    LoaderStruct type;
    std::uint32_t version;
    std::size_t size;
    std::uint32_t minInterface;
    std::uint32_t maxInterface;
    XrVersion minApi;
    XrVersion maxApi;
};
struct RuntimeRequest
{
    LoaderStruct type;
    std::uint32_t version;
    std::size_t size;
    std::uint32_t runtimeInterface;
    XrVersion runtimeApi;
    PFN_xrGetInstanceProcAddr getInstanceProcAddr;
};

} // namespace

XrTime FakeState::now()
{
    timespec time{};
    clock_gettime(CLOCK_MONOTONIC, &time);
    return static_cast<XrTime>(time.tv_sec) * 1000000000 + time.tv_nsec;
}

XrVector3f FakeState::swayAt(XrTime time) const
{
    constexpr double kPi = 3.14159265358979323846;
    const auto way =
        static_cast<float>(std::sin(kPi * 1e-9 * static_cast<double>(time - start)) / kPi);
    return {speed.x * way, speed.y * way, speed.z * way};
}

XrPosef FakeState::eyeAt(int eye, XrTime time) const
{
    // Outwards, about y.
    constexpr float kHalfCant = 0.5F * 5.0F * 3.14159265F / 180.0F;
    constexpr float kHalfIpd = 0.032F;
    const float side = eye == 0 ? 1.0F : -1.0F;
    XrPosef pose = head.value_or(XrPosef{{0, 0, 0, 1}, {0, 0, 0}});
    const XrQuaternionf h = pose.orientation;
    const float s = side * std::sin(kHalfCant);
    const float c = std::cos(kHalfCant);
    // The head's turn, then the cant.
    pose.orientation = {h.x * c - h.z * s, h.w * s + h.y * c, h.z * c + h.x * s, h.w * c - h.y * s};
    const float along = -side * kHalfIpd; // of the head's x
    pose.position.x += along * (1.0F - 2.0F * (h.y * h.y + h.z * h.z));
    pose.position.y += along * 2.0F * (h.x * h.y + h.w * h.z);
    pose.position.z += along * 2.0F * (h.x * h.z - h.w * h.y);
    const XrVector3f sway = swayAt(time);
    pose.position.x += sway.x;
    pose.position.y += sway.y;
    pose.position.z += sway.z;
    return pose;
}

XrFovf FakeState::fovOf(int eye)
{
    if (eye == 0) return {-0.85F, 0.65F, 0.75F, -0.80F};
    return {-0.60F, 0.90F, 0.70F, -0.85F};
}

FakeAccess::FakeAccess() : _lock(gMutex) {}

FakeAccess::~FakeAccess()
{
    gChanged.notify_all();
}

FakeState* FakeAccess::operator->() const
{
    return &gState;
}

FakeState& FakeAccess::operator*() const
{
    return gState;
}

void FakeAccess::waitWhileBlocked(const std::string& function)
{
    gChanged.wait(_lock, [&function] { return gState.blocked != function; });
}

extern "C" XrResult xrNegotiateLoaderRuntimeInterface(const LoaderInfo* loader,
                                                      RuntimeRequest* request)
{
    if (loader->type != LOADER_INFO || request->type != RUNTIME_REQUEST || loader->minInterface > 1)
        return XR_ERROR_INITIALIZATION_FAILED;
    request->runtimeInterface = 1;
    request->runtimeApi = XR_CURRENT_API_VERSION;
    request->getInstanceProcAddr = getInstanceProcAddr;
    return XR_SUCCESS;
}
