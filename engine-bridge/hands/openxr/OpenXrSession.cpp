#include "engine-bridge/hands/openxr/OpenXrSession.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include <dlfcn.h>
#include <fmt/format.h>
#include <openxr/openxr_reflection.h>

namespace midair::bridge
{

namespace
{

constexpr std::array<const char*, 3> kNeeded = {XR_EXT_HAND_TRACKING_EXTENSION_NAME,
                                                XR_MND_HEADLESS_EXTENSION_NAME,
                                                XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME};

/// A larger count from the runtime is lowered to this.
constexpr std::uint32_t kMostExtensions = 10000;

/// A runtime's text may fill its array without a terminating zero.
template<std::size_t N>
std::string textOf(const char (&field)[N])
{
    return std::string(field, std::find(field, field + N, '\0'));
}

std::vector<XrExtensionProperties>
extensionsOf(PFN_xrEnumerateInstanceExtensionProperties enumerate)
{
    std::vector<XrExtensionProperties> extensions;
    std::uint32_t count = 0;
    XrResult result = enumerate(nullptr, 0, &count, nullptr);
    if (XR_SUCCEEDED(result))
    {
        count = std::min(count, kMostExtensions);
        extensions.resize(count, {XR_TYPE_EXTENSION_PROPERTIES, nullptr, {}, 0});
        result = enumerate(nullptr, count, &count, extensions.data());
    }
    if (XR_FAILED(result))
        throw OpenXrError("the loader finds no OpenXR runtime (" + resultName(result) +
                              "); no hands. Install one, such as Monado, or name its manifest in "
                              "XR_RUNTIME_JSON",
                          false);
    extensions.resize(std::min<std::size_t>(count, extensions.size()));
    return extensions;
}

/// "a, b and c".
std::string listed(const std::vector<std::string>& names)
{
    std::string text;
    for (std::size_t i = 0; i < names.size(); ++i)
        text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
    return text;
}

/// The most events handled in one call; the rest waits for the next call.
constexpr int kMostEvents = 100;

constexpr std::uint32_t kMostSpaces = 1000; ///< a larger count from the runtime is lowered to it

const char* spaceName(XrReferenceSpaceType type)
{
    return type == XR_REFERENCE_SPACE_TYPE_STAGE ? "stage" : "local";
}

template<typename Event>
Event as(const XrEventDataBuffer& buffer)
{
    Event event{};
    std::memcpy(&event, &buffer, sizeof event);
    return event;
}

std::string described(const XrHandJointLocationEXT& location)
{
    const XrVector3f& p = location.pose.position;
    return fmt::format("position {:g} {:g} {:g} m, radius {:g} m", p.x, p.y, p.z, location.radius);
}

/// Copies a joint if its values are plausible. Returns false if the runtime says that it is valid
/// but its position or radius is impossible.
bool fill(const XrHandJointLocationEXT& location, HandJoint& joint)
{
    const XrVector3f& p = location.pose.position;
    const XrQuaternionf& q = location.pose.orientation;
    // A member that is not valid may hold anything, so it stays at its default.
    if ((location.locationFlags & XR_SPACE_LOCATION_ORIENTATION_VALID_BIT) != 0)
    {
        const Eigen::Quaterniond orientation(Eigen::Quaternionf(q.w, q.x, q.y, q.z));
        joint.orientationValid = std::abs(orientation.norm() - 1.0) < 1e-2; // false for NaN
        if (joint.orientationValid) joint.orientation = orientation.normalized();
    }
    if ((location.locationFlags & XR_SPACE_LOCATION_POSITION_VALID_BIT) == 0) return true;
    const Eigen::Vector3d position = Eigen::Vector3f(p.x, p.y, p.z).cast<double>();
    joint.positionValid = position.norm() < OpenXrSession::kFarthest_m && location.radius > 0.0f &&
                          location.radius <= OpenXrSession::kThickest_m;
    if (!joint.positionValid) return false;
    joint.position = position;
    joint.radius_m = location.radius;
    return true;
}

} // namespace

std::string resultName(XrResult result)
{
#define MIDAIR_NAME(name, value)                                                                   \
    case name:                                                                                     \
        return #name;
    switch (result)
    {
        XR_LIST_ENUM_XrResult(MIDAIR_NAME) default : break;
    }
#undef MIDAIR_NAME
    return fmt::format("XrResult {}", static_cast<int>(result));
}

OpenXrInstance::OpenXrInstance(const std::string& loader)
{
    loadLibrary(loader);
    try
    {
        create();
        findSystem();
    }
    catch (...)
    {
        if (_functions.destroyInstance) _functions.destroyInstance(_instance);
        throw;
    }
}

OpenXrInstance::~OpenXrInstance()
{
    _functions.destroyInstance(_instance);
}

void OpenXrInstance::loadLibrary(const std::string& loader)
{
    // The library is never closed: runtimes leave threads behind that may still be in it.
    void* library = dlopen(loader.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library)
    {
        // NOLINTNEXTLINE(concurrency-mt-unsafe): the C library keeps one a thread
        const char* why = dlerror();
        throw OpenXrError("the loader can't be loaded (" + std::string(why ? why : loader) +
                              "); no hands. Install libopenxr-loader1 and an OpenXR runtime",
                          false);
    }
    _functions.getInstanceProcAddr =
        reinterpret_cast<PFN_xrGetInstanceProcAddr>(dlsym(library, "xrGetInstanceProcAddr"));
    if (!_functions.getInstanceProcAddr)
        throw OpenXrError(
            loader + " is no OpenXR loader (it has no xrGetInstanceProcAddr); no hands", false);
}

template<typename F>
void OpenXrInstance::load(const char* name, F& function) const
{
    PFN_xrVoidFunction found = nullptr;
    const XrResult result = _functions.getInstanceProcAddr(_instance, name, &found);
    if (XR_FAILED(result) || !found)
        throw OpenXrError(_runtime + " has no function " + name + " (" + resultName(result) +
                              "); no hands",
                          false);
    function = reinterpret_cast<F>(found);
}

void OpenXrInstance::create()
{
    PFN_xrEnumerateInstanceExtensionProperties enumerate = nullptr;
    PFN_xrCreateInstance createInstance = nullptr;
    load("xrEnumerateInstanceExtensionProperties", enumerate);
    load("xrCreateInstance", createInstance);
    const std::vector<XrExtensionProperties> offered = extensionsOf(enumerate);
    // The runtime's name is available only through an instance, so one is made with the extensions
    // that are there.
    std::vector<const char*> present;
    std::vector<std::string> missing;
    for (const char* name : kNeeded)
        if (std::any_of(offered.begin(),
                        offered.end(),
                        [name](const XrExtensionProperties& extension)
                        { return textOf(extension.extensionName) == name; }))
            present.push_back(name);
        else
            missing.emplace_back(name);

    XrInstanceCreateInfo info{};
    info.type = XR_TYPE_INSTANCE_CREATE_INFO;
    std::strcpy(info.applicationInfo.applicationName, "osgMidair");
    info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
    info.enabledExtensionCount = static_cast<std::uint32_t>(present.size());
    info.enabledExtensionNames = present.data();
    const XrResult result = createInstance(&info, &_instance);
    if (result == XR_ERROR_LIMIT_REACHED)
        throw OpenXrError("this program has an OpenXR instance already, and the loader allows no "
                          "second one (XR_ERROR_LIMIT_REACHED); no hands. Set hands with "
                          "InjectedHands instead",
                          false);
    if (XR_FAILED(result))
        throw OpenXrError("the runtime can't be reached (xrCreateInstance: " + resultName(result) +
                              "); no hands. Is its service running?",
                          true);
    loadFunctions();
    if (!missing.empty())
        throw OpenXrError(_runtime + " has no " + listed(missing) +
                              "; no hands. They take a runtime with " +
                              listed({kNeeded.begin(), kNeeded.end()}) + ", such as Monado",
                          false);
    load("xrConvertTimespecTimeToTimeKHR", _functions.convertTimespecTimeToTime);
    load("xrCreateHandTrackerEXT", _functions.createHandTracker);
    load("xrDestroyHandTrackerEXT", _functions.destroyHandTracker);
    load("xrLocateHandJointsEXT", _functions.locateHandJoints);
}

void OpenXrInstance::loadFunctions()
{
    load("xrDestroyInstance", _functions.destroyInstance);
    load("xrGetInstanceProperties", _functions.getInstanceProperties);
    load("xrGetSystem", _functions.getSystem);
    load("xrGetSystemProperties", _functions.getSystemProperties);
    load("xrPollEvent", _functions.pollEvent);
    load("xrCreateSession", _functions.createSession);
    load("xrDestroySession", _functions.destroySession);
    load("xrBeginSession", _functions.beginSession);
    load("xrEndSession", _functions.endSession);
    load("xrEnumerateReferenceSpaces", _functions.enumerateReferenceSpaces);
    load("xrCreateReferenceSpace", _functions.createReferenceSpace);
    load("xrDestroySpace", _functions.destroySpace);
    load("xrLocateSpace", _functions.locateSpace);

    XrInstanceProperties properties{};
    properties.type = XR_TYPE_INSTANCE_PROPERTIES;
    check(_functions.getInstanceProperties(_instance, &properties), "xrGetInstanceProperties");
    const XrVersion version = properties.runtimeVersion;
    _runtime = fmt::format("{} {}.{}.{}",
                           textOf(properties.runtimeName),
                           XR_VERSION_MAJOR(version),
                           XR_VERSION_MINOR(version),
                           XR_VERSION_PATCH(version));
}

void OpenXrInstance::findSystem()
{
    XrSystemGetInfo wanted{};
    wanted.type = XR_TYPE_SYSTEM_GET_INFO;
    wanted.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
    const XrResult result = _functions.getSystem(_instance, &wanted, &_system);
    if (result == XR_ERROR_FORM_FACTOR_UNAVAILABLE)
        throw OpenXrError(_runtime + " has no headset now (" + resultName(result) +
                              "); no hands until it is connected",
                          true);
    check(result, "xrGetSystem");

    XrSystemHandTrackingPropertiesEXT tracking{};
    tracking.type = XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT;
    XrSystemProperties properties{};
    properties.type = XR_TYPE_SYSTEM_PROPERTIES;
    properties.next = &tracking;
    check(_functions.getSystemProperties(_instance, _system, &properties), "xrGetSystemProperties");
    if (!tracking.supportsHandTracking)
        throw OpenXrError(_runtime + ": \"" + textOf(properties.systemName) +
                              "\" doesn't track hands; no hands. It takes a headset or camera "
                              "that does",
                          false);
}

void OpenXrInstance::check(XrResult result, const char* call) const
{
    if (XR_SUCCEEDED(result)) return;
    const bool lost = result == XR_ERROR_SESSION_LOST || result == XR_ERROR_INSTANCE_LOST;
    throw OpenXrError(_runtime + ": " + call + ": " + resultName(result) + "; no hands" +
                          (lost ? " until it is back" : ""),
                      lost);
}

XrTime OpenXrInstance::now() const
{
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    XrTime time = 0;
    check(_functions.convertTimespecTimeToTime(_instance, &now, &time),
          "xrConvertTimespecTimeToTimeKHR");
    return time;
}

OpenXrSession::OpenXrSession(const std::string& loader, OpenXrSpace space, Say say) :
    _say(std::move(say)),
    _instance(loader)
{
    const OpenXrFunctions& xr = _instance.functions();
    try
    {
        XrSessionCreateInfo info{};
        info.type = XR_TYPE_SESSION_CREATE_INFO;
        info.systemId = _instance.system();
        _instance.check(xr.createSession(_instance.handle(), &info, &_session), "xrCreateSession");
        createSpace(space);
        for (std::size_t i = 0; i < _trackers.size(); ++i)
        {
            XrHandTrackerCreateInfoEXT hand{};
            hand.type = XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT;
            hand.hand = i == 0 ? XR_HAND_LEFT_EXT : XR_HAND_RIGHT_EXT;
            hand.handJointSet = XR_HAND_JOINT_SET_DEFAULT_EXT;
            _instance.check(xr.createHandTracker(_session, &hand, &_trackers[i]),
                            "xrCreateHandTrackerEXT");
        }
    }
    catch (...)
    {
        destroy();
        throw;
    }
}

OpenXrSession::~OpenXrSession()
{
    destroy();
}

void OpenXrSession::destroy()
{
    const OpenXrFunctions& xr = _instance.functions();
    for (XrHandTrackerEXT tracker : _trackers)
        if (tracker != XR_NULL_HANDLE) xr.destroyHandTracker(tracker);
    for (XrSpace space : {_view, _space})
        if (space != XR_NULL_HANDLE) xr.destroySpace(space);
    if (_session != XR_NULL_HANDLE) xr.destroySession(_session);
}

void OpenXrSession::createSpace(OpenXrSpace space)
{
    const OpenXrFunctions& xr = _instance.functions();
    std::uint32_t count = 0;
    _instance.check(xr.enumerateReferenceSpaces(_session, 0, &count, nullptr),
                    "xrEnumerateReferenceSpaces");
    std::vector<XrReferenceSpaceType> offered(std::min(count, kMostSpaces));
    _instance.check(
        xr.enumerateReferenceSpaces(
            _session, static_cast<std::uint32_t>(offered.size()), &count, offered.data()),
        "xrEnumerateReferenceSpaces");
    const bool hasStage =
        std::find(offered.begin(), offered.end(), XR_REFERENCE_SPACE_TYPE_STAGE) != offered.end();
    if (space == OpenXrSpace::STAGE && !hasStage)
        throw OpenXrError(runtime() + " has no stage space; no hands. openxr:?space=local takes "
                                      "the other one",
                          false);
    if (hasStage && space != OpenXrSpace::LOCAL) _spaceType = XR_REFERENCE_SPACE_TYPE_STAGE;
    _space = makeSpace(_spaceType);
}

XrSpace OpenXrSession::makeSpace(XrReferenceSpaceType type)
{
    XrReferenceSpaceCreateInfo info{};
    info.type = XR_TYPE_REFERENCE_SPACE_CREATE_INFO;
    info.referenceSpaceType = type;
    info.poseInReferenceSpace.orientation.w = 1.0f;
    XrSpace space = XR_NULL_HANDLE;
    _instance.check(_instance.functions().createReferenceSpace(_session, &info, &space),
                    "xrCreateReferenceSpace");
    return space;
}

void OpenXrSession::handleEvents()
{
    for (int i = 0; i < kMostEvents; ++i)
    {
        XrEventDataBuffer event{};
        event.type = XR_TYPE_EVENT_DATA_BUFFER;
        const XrResult result = _instance.functions().pollEvent(_instance.handle(), &event);
        _instance.check(result, "xrPollEvent");
        if (result == XR_EVENT_UNAVAILABLE) return;
        if (event.type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED)
        {
            const auto change = as<XrEventDataSessionStateChanged>(event);
            if (change.session == _session) handleState(change.state);
        }
        else if (event.type == XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING)
            throw OpenXrError(runtime() + " is going away; no hands until it is back", true);
        else if (event.type == XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING)
        {
            const auto change = as<XrEventDataReferenceSpaceChangePending>(event);
            if (change.session == _session && change.referenceSpaceType == _spaceType)
                _say("openxr: " + runtime() + " moves the origin of its " + spaceName(_spaceType) +
                     " space: hands are no longer where they were calibrated to be");
        }
    }
}

void OpenXrSession::handleState(XrSessionState state)
{
    const OpenXrFunctions& xr = _instance.functions();
    switch (state)
    {
    case XR_SESSION_STATE_READY:
    {
        XrSessionBeginInfo info{};
        info.type = XR_TYPE_SESSION_BEGIN_INFO;
        info.primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
        _instance.check(xr.beginSession(_session, &info), "xrBeginSession");
        _running = true;
        break;
    }
    case XR_SESSION_STATE_STOPPING:
        _running = false;
        _instance.check(xr.endSession(_session), "xrEndSession");
        _say("openxr: " + runtime() + " stopped the session; no hands until it goes on");
        break;
    case XR_SESSION_STATE_LOSS_PENDING:
        throw OpenXrError(runtime() + " loses the session; no hands until it is back", true);
    case XR_SESSION_STATE_EXITING:
        throw OpenXrError(runtime() + " ended the session; no hands. Set the hand source again to "
                                      "begin another",
                          false);
    default:
        break;
    }
}

void OpenXrSession::locate(HandFrame& frame, double ahead_s)
{
    frame.hands.clear();
    if (!_running) return;
    const XrTime now = _instance.now();
    const auto ahead = static_cast<XrDuration>(std::llround(1e9 * ahead_s));
    for (int id = 0; id < static_cast<int>(_trackers.size()); ++id)
    {
        Hand hand;
        hand.id = id;
        if (locateHand(id, now, ahead, hand)) frame.hands.push_back(hand);
    }
}

void OpenXrSession::locateHead(Head& head, double ahead_s)
{
    head = {};
    if (!_running) return;
    if (_view == XR_NULL_HANDLE) _view = makeSpace(XR_REFERENCE_SPACE_TYPE_VIEW);
    const XrTime now = _instance.now();
    const auto ahead = _refusesLaterHead ? 0 : static_cast<XrDuration>(std::llround(1e9 * ahead_s));
    XrSpaceLocation location{};
    location.type = XR_TYPE_SPACE_LOCATION;
    const OpenXrFunctions& xr = _instance.functions();
    XrResult result = xr.locateSpace(_view, _space, now + ahead, &location);
    if (result == XR_ERROR_TIME_INVALID && ahead > 0)
    {
        _refusesLaterHead = true;
        _say("openxr: " + runtime() + " tells no head of a later time (" + resultName(result) +
             "): it is that of now. prediction=kalman predicts it");
        result = xr.locateSpace(_view, _space, now, &location);
    }
    if (result == XR_ERROR_SESSION_LOST || result == XR_ERROR_INSTANCE_LOST)
        _instance.check(result, "xrLocateSpace");
    if (XR_FAILED(result))
        _say("openxr: " + runtime() + ": xrLocateSpace: " + resultName(result) +
             "; no head as long as that lasts");
    constexpr XrSpaceLocationFlags kKnown = XR_SPACE_LOCATION_ORIENTATION_VALID_BIT |
                                            XR_SPACE_LOCATION_POSITION_VALID_BIT |
                                            XR_SPACE_LOCATION_POSITION_TRACKED_BIT;
    if (XR_FAILED(result) || (location.locationFlags & kKnown) != kKnown) return;
    const XrVector3f& p = location.pose.position;
    const XrQuaternionf& q = location.pose.orientation;
    const Eigen::Quaterniond turn(Eigen::Quaternionf(q.w, q.x, q.y, q.z));
    const Eigen::Vector3d place = Eigen::Vector3f(p.x, p.y, p.z).cast<double>();
    // False for NaN, too.
    head.isTracked = place.norm() < kFarthest_m && std::abs(turn.norm() - 1.0) < 1e-2;
    if (head.isTracked) head.pose = headPose(place, turn);
}

XrResult OpenXrSession::askRuntime(int id, XrTime time, XrHandJointLocationsEXT& locations) const
{
    XrHandJointsLocateInfoEXT info{};
    info.type = XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT;
    info.baseSpace = _space;
    info.time = time;
    return _instance.functions().locateHandJoints(
        _trackers[static_cast<std::size_t>(id)], &info, &locations);
}

bool OpenXrSession::locateHand(int id, XrTime now, XrDuration ahead, Hand& hand)
{
    static_assert(HAND_JOINTS == XR_HAND_JOINT_COUNT_EXT, "one order of joints for both");
    std::array<XrHandJointLocationEXT, HAND_JOINTS> located{};
    XrHandJointLocationsEXT locations{};
    locations.type = XR_TYPE_HAND_JOINT_LOCATIONS_EXT;
    locations.jointCount = HAND_JOINTS;
    locations.jointLocations = located.data();
    const bool isLater = ahead > 0 && !_refusesLater;
    XrResult result = askRuntime(id, isLater ? now + ahead : now, locations);
    if (result == XR_ERROR_TIME_INVALID && isLater)
    {
        _refusesLater = true;
        _say("openxr: " + runtime() + " tells no hands of a later time (" + resultName(result) +
             "): they are those of now, and are felt late. prediction=kalman predicts them");
        result = askRuntime(id, now, locations);
    }
    if (result == XR_ERROR_SESSION_LOST || result == XR_ERROR_INSTANCE_LOST)
        _instance.check(result, "xrLocateHandJointsEXT");
    if (XR_FAILED(result))
    {
        _say("openxr: " + runtime() + ": xrLocateHandJointsEXT: " + resultName(result) +
             "; no hands as long as that lasts");
        return false;
    }
    if (!locations.isActive) return false;
    bool any = false;
    for (std::size_t i = 0; i < located.size(); ++i)
    {
        HandJoint& joint = hand.joints[i];
        if (!fill(located[i], joint) && _leftOut++ == 0)
            _say("openxr: " + runtime() + " gives an impossible " + jointName(static_cast<int>(i)) +
                 " of the " + (id == 0 ? "left" : "right") + " hand (" + described(located[i]) +
                 "); positions within 100 m and radii over 0, up to 0.1 m are believed, other "
                 "joints left out");
        any = any || joint.positionValid;
    }
    return any;
}

} // namespace midair::bridge
