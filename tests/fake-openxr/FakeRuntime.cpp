// An OpenXR runtime without a headset, for Debian's loader: the test that links this library shares
// its state with the runtime, since the loader gets the same library.
#include "tests/fake-openxr/FakeRuntime.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

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

XrSessionState gSession = XR_SESSION_STATE_UNKNOWN;
bool gRunning = false;
bool gHeadless = false;
XrTime gTime = 0;                   // as last converted
std::array<FakeHand, 2> gLast = {}; // left, right

template<typename H>
H handle(std::uintptr_t number)
{
    return reinterpret_cast<H>(number);
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
    gHeadless = false;
    for (std::uint32_t i = 0; i < info->enabledExtensionCount; ++i)
    {
        const std::string name = info->enabledExtensionNames[i];
        if (std::count(state->extensions.begin(), state->extensions.end(), name) == 0)
            return XR_ERROR_EXTENSION_NOT_PRESENT;
        gHeadless = gHeadless || name == "XR_MND_headless";
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
    if (!gHeadless) return XR_ERROR_GRAPHICS_DEVICE_INVALID;
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
    if (space != handle<XrSpace>(kView) || base != handle<XrSpace>(kSpace))
        return XR_ERROR_HANDLE_INVALID;
    if (time < gTime || time > gTime + 1000000000) return XR_ERROR_TIME_INVALID;
    if (time > gTime && !state->predicts) return XR_ERROR_TIME_INVALID;
    state->headAhead = time - gTime;
    // One that is lost is where the runtime thinks that it is.
    location->locationFlags =
        XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT;
    if (state->head) location->locationFlags |= XR_SPACE_LOCATION_POSITION_TRACKED_BIT;
    location->pose = state->head.value_or(XrPosef{{0, 0, 0, 1}, {0, 0, 0}});
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
    if (info->baseSpace != handle<XrSpace>(kSpace)) return XR_ERROR_HANDLE_INVALID;
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
    ++state->located;
    return XR_SUCCESS;
}

XrResult getInstanceProcAddr(XrInstance, const char* name, PFN_xrVoidFunction* function)
{
#define FAKE(name, function)                                                                       \
    {                                                                                              \
        name, reinterpret_cast<PFN_xrVoidFunction>(function)                                       \
    }
    static const std::map<std::string, PFN_xrVoidFunction> functions = {
        FAKE("xrGetInstanceProcAddr", getInstanceProcAddr),
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
        FAKE("xrConvertTimespecTimeToTimeKHR", convertTime),
        FAKE("xrCreateHandTrackerEXT", createHandTracker),
        FAKE("xrDestroyHandTrackerEXT", destroyHandTracker),
        FAKE("xrLocateHandJointsEXT", locateHandJoints)};
#undef FAKE
    const auto found = functions.find(name);
    *function = found == functions.end() ? nullptr : found->second;
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
