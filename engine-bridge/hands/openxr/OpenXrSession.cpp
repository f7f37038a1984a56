#include "engine-bridge/hands/openxr/OpenXrSession.h"

#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <map>
#include <utility>
#include <vector>

#include <dlfcn.h>
#include <fmt/format.h>
#include <openxr/openxr_reflection.h>

namespace midair::bridge
{

namespace
{

using Names = std::vector<const char*>;

const Names kForHands = {XR_EXT_HAND_TRACKING_EXTENSION_NAME,
                         XR_MND_HEADLESS_EXTENSION_NAME,
                         XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME};
const Names kForPicture = {"XR_KHR_opengl_enable"};
/// Optional, with a picture.
const Names kBesides = {XR_EXT_HAND_TRACKING_EXTENSION_NAME,
                        XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME,
                        XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME,
                        XR_FB_PASSTHROUGH_EXTENSION_NAME,
                        XR_MSFT_SPATIAL_ANCHOR_EXTENSION_NAME};

/// Limit of a count from the runtime.
constexpr std::uint32_t kMostExtensions = 10000;

/// A runtime's text may fill its array without a terminating zero.
template<std::size_t N>
std::string textOf(const char (&field)[N])
{
    return std::string(field, std::find(field, field + N, '\0'));
}

std::vector<XrExtensionProperties>
extensionsOf(PFN_xrEnumerateInstanceExtensionProperties enumerate, const std::string& without)
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
        throw OpenXrError("the loader finds no OpenXR runtime (" + resultName(result) + "); " +
                              without +
                              ". Install one, such as Monado, or name its manifest in "
                              "XR_RUNTIME_JSON",
                          false);
    extensions.resize(std::min<std::size_t>(count, extensions.size()));
    return extensions;
}

/// True if \a loader was already in the process at the first check.
bool wasLoadedBefore(const std::string& loader)
{
    static base::Mutex mutex;
    static std::map<std::string, bool> known;
    const base::Lock lock(mutex);
    const auto found = known.find(loader);
    if (found != known.end()) return found->second;
    return known[loader] = dlopen(loader.c_str(), RTLD_NOW | RTLD_NOLOAD) != nullptr;
}

/// "a, b and c".
std::string listed(const std::vector<std::string>& names)
{
    std::string text;
    for (std::size_t i = 0; i < names.size(); ++i)
        text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
    return text;
}

/// Limit of events per call; the rest waits for the next call.
constexpr int kMostEvents = 100;

constexpr std::uint32_t kMostSpaces = 1000; ///< limit of a count from the runtime

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

XrPosef poseFor(const Eigen::Isometry3d& pose)
{
    const Eigen::Vector3f p = pose.translation().cast<float>();
    const Eigen::Quaternionf q = Eigen::Quaterniond(pose.linear()).cast<float>();
    return {{q.x(), q.y(), q.z(), q.w()}, {p.x(), p.y(), p.z()}};
}

/// Copies a joint if its values are plausible. Returns false if the runtime marks it as valid but
/// its position or radius is impossible.
bool fill(const XrHandJointLocationEXT& location, HandJoint& joint)
{
    const XrVector3f& p = location.pose.position;
    const XrQuaternionf& q = location.pose.orientation;
    // An invalid member may hold anything, so it stays at its default.
    if ((location.locationFlags & XR_SPACE_LOCATION_ORIENTATION_VALID_BIT) != 0)
    {
        const Eigen::Quaterniond orientation(Eigen::Quaternionf(q.w, q.x, q.y, q.z));
        joint.orientationValid = std::abs(orientation.norm() - 1.0) < 1e-2; // also false for NaN
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

OpenXrInstance::OpenXrInstance(const std::string& loader, Use use) :
    _without(use == Use::HANDS ? "no hands" : "no picture in a headset")
{
    loadLibrary(loader);
    try
    {
        create(use);
        findSystem(use);
    }
    catch (...)
    {
        if (_functions.destroyInstance) _functions.destroyInstance(_instance);
        throw;
    }
}

OpenXrInstance::OpenXrInstance(const OpenXrHandles& handles) :
    _instance(static_cast<XrInstance>(handles.instance)),
    _isOwn(false)
{
    _functions.getInstanceProcAddr =
        reinterpret_cast<PFN_xrGetInstanceProcAddr>(handles.getInstanceProcAddr);
    loadFunctions();
    PFN_xrVoidFunction found = nullptr;
    const auto isThere = [&](const char* name)
    { return XR_SUCCEEDED(_functions.getInstanceProcAddr(_instance, name, &found)) && found; };
    if (isThere("xrConvertTimespecTimeToTimeKHR"))
        load("xrConvertTimespecTimeToTimeKHR", _functions.convertTimespecTimeToTime);
    _tracksHands = isThere("xrCreateHandTrackerEXT");
    if (_tracksHands) loadHandFunctions();
}

OpenXrInstance::~OpenXrInstance()
{
    if (_isOwn) _functions.destroyInstance(_instance);
}

void OpenXrInstance::loadLibrary(const std::string& loader)
{
    _isLoaderPrograms = wasLoadedBefore(loader);
    // The library is never closed: runtimes leave threads behind that may still run in it.
    void* library = dlopen(loader.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library)
    {
        // NOLINTNEXTLINE(concurrency-mt-unsafe): the C library keeps one a thread
        const char* why = dlerror();
        throw OpenXrError("the loader can't be loaded (" + std::string(why ? why : loader) + "); " +
                              _without + ". Install libopenxr-loader1 and an OpenXR runtime",
                          false);
    }
    _functions.getInstanceProcAddr =
        reinterpret_cast<PFN_xrGetInstanceProcAddr>(dlsym(library, "xrGetInstanceProcAddr"));
    if (!_functions.getInstanceProcAddr)
        throw OpenXrError(
            loader + " is no OpenXR loader (it has no xrGetInstanceProcAddr); " + _without, false);
}

PFN_xrVoidFunction OpenXrInstance::find(const char* name) const
{
    PFN_xrVoidFunction found = nullptr;
    const XrResult result = _functions.getInstanceProcAddr(_instance, name, &found);
    if (XR_FAILED(result) || !found)
        throw OpenXrError(_runtime + " has no function " + name + " (" + resultName(result) +
                              "); " + _without,
                          false);
    return found;
}

void OpenXrInstance::create(Use use)
{
    PFN_xrEnumerateInstanceExtensionProperties enumerate = nullptr;
    PFN_xrCreateInstance createInstance = nullptr;
    load("xrEnumerateInstanceExtensionProperties", enumerate);
    load("xrCreateInstance", createInstance);
    const std::vector<XrExtensionProperties> offered = extensionsOf(enumerate, _without);
    const auto isOffered = [&offered](const char* name)
    {
        return std::any_of(offered.begin(),
                           offered.end(),
                           [name](const XrExtensionProperties& extension)
                           { return textOf(extension.extensionName) == name; });
    };
    // The runtime's name is available only through an instance, so this makes one with the
    // supported extensions.
    const Names& needed = use == Use::HANDS ? kForHands : kForPicture;
    Names present;
    std::vector<std::string> missing;
    for (const char* name : needed)
        if (isOffered(name))
            present.push_back(name);
        else
            missing.emplace_back(name);
    if (use == Use::PICTURE)
        std::copy_if(kBesides.begin(), kBesides.end(), std::back_inserter(present), isOffered);
    _extensions.insert(present.begin(), present.end());

    XrInstanceCreateInfo info{};
    info.type = XR_TYPE_INSTANCE_CREATE_INFO;
    std::strcpy(info.applicationInfo.applicationName, "osgMidair");
    info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
    info.enabledExtensionCount = static_cast<std::uint32_t>(present.size());
    info.enabledExtensionNames = present.data();
    const XrResult result = createInstance(&info, &_instance);
    if (result == XR_ERROR_LIMIT_REACHED)
        throw OpenXrError("this program has an OpenXR instance already, and the loader allows no "
                          "second one (XR_ERROR_LIMIT_REACHED); " +
                              _without + ". Hand its session over: osgMidair::XrSession",
                          false);
    if (XR_FAILED(result))
        throw OpenXrError("the runtime can't be reached (xrCreateInstance: " + resultName(result) +
                              "); " + _without + ". Is its service running?",
                          true);
    loadFunctions();
    if (!missing.empty())
        throw OpenXrError(_runtime + " has no " + listed(missing) + "; " + _without +
                              (use == Use::HANDS ? ". They take" : ". It takes") +
                              " a runtime with " + listed({needed.begin(), needed.end()}) +
                              ", such as Monado",
                          false);
    if (has(XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME))
        load("xrConvertTimespecTimeToTimeKHR", _functions.convertTimespecTimeToTime);
    if (has(XR_EXT_HAND_TRACKING_EXTENSION_NAME)) loadHandFunctions();
    if (!has(XR_MSFT_SPATIAL_ANCHOR_EXTENSION_NAME)) return;
    load("xrCreateSpatialAnchorMSFT", _functions.createAnchor);
    load("xrCreateSpatialAnchorSpaceMSFT", _functions.createAnchorSpace);
    load("xrDestroySpatialAnchorMSFT", _functions.destroyAnchor);
}

void OpenXrInstance::loadHandFunctions()
{
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

void OpenXrInstance::findSystem(Use use)
{
    XrSystemGetInfo wanted{};
    wanted.type = XR_TYPE_SYSTEM_GET_INFO;
    wanted.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
    const XrResult result = _functions.getSystem(_instance, &wanted, &_system);
    if (result == XR_ERROR_FORM_FACTOR_UNAVAILABLE)
        throw OpenXrError(_runtime + " has no headset now (" + resultName(result) + "); " +
                              _without + " until it is connected",
                          true);
    check(result, "xrGetSystem");
    if (!has(XR_EXT_HAND_TRACKING_EXTENSION_NAME)) return;

    XrSystemHandTrackingPropertiesEXT tracking{};
    tracking.type = XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT;
    XrSystemProperties properties{};
    properties.type = XR_TYPE_SYSTEM_PROPERTIES;
    properties.next = &tracking;
    check(_functions.getSystemProperties(_instance, _system, &properties), "xrGetSystemProperties");
    _tracksHands = tracking.supportsHandTracking == XR_TRUE;
    if (!_tracksHands && use == Use::HANDS)
        throw OpenXrError(_runtime + ": \"" + textOf(properties.systemName) +
                              "\" doesn't track hands; no hands. It takes a headset or camera "
                              "that does",
                          false);
}

void OpenXrInstance::check(XrResult result, const char* call) const
{
    if (XR_SUCCEEDED(result)) return;
    const bool lost = result == XR_ERROR_SESSION_LOST || result == XR_ERROR_INSTANCE_LOST;
    throw OpenXrError(_runtime + ": " + call + ": " + resultName(result) + "; " + _without +
                          (lost ? " until it is back" : ""),
                      lost);
}

XrTime OpenXrInstance::now() const
{
    if (!_functions.convertTimespecTimeToTime)
        return _known.time +
               static_cast<XrTime>(1e9 * (base::steadySeconds() - _known.at_s.load()));
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    XrTime time = 0;
    check(_functions.convertTimespecTimeToTime(_instance, &now, &time),
          "xrConvertTimespecTimeToTimeKHR");
    return time;
}

void OpenXrInstance::setTime(XrTime time)
{
    _known.time = time;
    _known.at_s = base::steadySeconds();
}

std::optional<double> OpenXrInstance::steadyTime(XrTime time) const
{
    if (!_functions.convertTimespecTimeToTime) return {};
    return base::steadySeconds() + 1e-9 * static_cast<double>(time - now());
}

OpenXrSession::OpenXrSession(const std::string& loader, OpenXrSpace space, Say say) :
    OpenXrSession(std::make_shared<OpenXrInstance>(loader, OpenXrInstance::Use::HANDS),
                  nullptr,
                  space,
                  std::move(say))
{
    if (_instance->isLoaderPrograms())
        _say("openxr: this program has loaded OpenXR itself, and the kit's tracker has the one "
             "instance that OpenXR allows: an xrCreateInstance of the program's own fails "
             "(XR_ERROR_LIMIT_REACHED). osgMidair::XrSession::open() before it prevents that, and "
             "its lend() hands the program's session over");
}

OpenXrSession::OpenXrSession(std::shared_ptr<OpenXrInstance> instance,
                             const void* binding,
                             OpenXrSpace space,
                             Say say) :
    _say(std::move(say)),
    _instance(std::move(instance))
{
    XrSessionCreateInfo info{};
    info.type = XR_TYPE_SESSION_CREATE_INFO;
    info.next = binding;
    info.systemId = _instance->system();
    _instance->check(_instance->functions().createSession(_instance->handle(), &info, &_session),
                     "xrCreateSession");
    begin(space);
}

OpenXrSession::OpenXrSession(const OpenXrHandles& handles, OpenXrSpace space, Say say) :
    _say(std::move(say)),
    _instance(std::make_shared<OpenXrInstance>(handles)),
    _session(static_cast<XrSession>(handles.session)),
    _space(static_cast<XrSpace>(handles.space)),
    _isSpaceOwn(!handles.space),
    _running(true)
{
    begin(space);
}

void OpenXrSession::begin(OpenXrSpace space)
{
    const OpenXrFunctions& xr = _instance->functions();
    try
    {
        if (_isSpaceOwn) createSpace(space);
        for (std::size_t i = 0; _instance->tracksHands() && i < _trackers.size(); ++i)
        {
            XrHandTrackerCreateInfoEXT hand{};
            hand.type = XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT;
            hand.hand = i == 0 ? XR_HAND_LEFT_EXT : XR_HAND_RIGHT_EXT;
            hand.handJointSet = XR_HAND_JOINT_SET_DEFAULT_EXT;
            _instance->check(xr.createHandTracker(_session, &hand, &_trackers[i]),
                             "xrCreateHandTrackerEXT");
        }
        if (!_instance->tracksHands())
            _say("openxr: " + runtime() +
                 " tracks no hands in this session: it needs a headset that tracks hands, and an "
                 "instance that was created with XR_EXT_hand_tracking");
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
    const OpenXrFunctions& xr = _instance->functions();
    for (XrHandTrackerEXT tracker : _trackers)
        if (tracker != XR_NULL_HANDLE) xr.destroyHandTracker(tracker);
    if (_view != XR_NULL_HANDLE) xr.destroySpace(_view);
    if (_isSpaceOwn && _space != XR_NULL_HANDLE) xr.destroySpace(_space);
    if (_anchor != XR_NULL_HANDLE) xr.destroyAnchor(_anchor);
    if (_instance->isOwn() && _session != XR_NULL_HANDLE) xr.destroySession(_session);
}

void OpenXrSession::createSpace(OpenXrSpace space)
{
    const OpenXrFunctions& xr = _instance->functions();
    std::uint32_t count = 0;
    _instance->check(xr.enumerateReferenceSpaces(_session, 0, &count, nullptr),
                     "xrEnumerateReferenceSpaces");
    std::vector<XrReferenceSpaceType> offered(std::min(count, kMostSpaces));
    _instance->check(
        xr.enumerateReferenceSpaces(
            _session, static_cast<std::uint32_t>(offered.size()), &count, offered.data()),
        "xrEnumerateReferenceSpaces");
    const bool hasStage =
        std::find(offered.begin(), offered.end(), XR_REFERENCE_SPACE_TYPE_STAGE) != offered.end();
    if (space == OpenXrSpace::STAGE && !hasStage)
        throw OpenXrError(runtime() + " has no stage space; " + _instance->without() +
                              ". openxr:?space=local takes the other one",
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
    _instance->check(_instance->functions().createReferenceSpace(_session, &info, &space),
                     "xrCreateReferenceSpace");
    return space;
}

void OpenXrSession::anchor(const Eigen::Isometry3d& place, XrTime time)
{
    const OpenXrFunctions& xr = _instance->functions();
    if (!xr.createAnchor || _anchor != XR_NULL_HANDLE || _refusesAnchor || !_isSpaceOwn) return;
    XrSpatialAnchorCreateInfoMSFT info{};
    info.type = XR_TYPE_SPATIAL_ANCHOR_CREATE_INFO_MSFT;
    info.space = _space;
    info.pose = poseFor(place);
    info.time = time;
    XrResult result = xr.createAnchor(_session, &info, &_anchor);
    if (result == XR_ERROR_CREATE_SPATIAL_ANCHOR_FAILED_MSFT) return; // the room is unknown yet
    XrSpace tied = XR_NULL_HANDLE;
    if (XR_SUCCEEDED(result))
    {
        XrSpatialAnchorSpaceCreateInfoMSFT space{};
        space.type = XR_TYPE_SPATIAL_ANCHOR_SPACE_CREATE_INFO_MSFT;
        space.anchor = _anchor;
        space.poseInAnchorSpace = poseFor(place.inverse());
        result = xr.createAnchorSpace(_session, &space, &tied);
    }
    if (XR_FAILED(result))
    {
        if (_anchor != XR_NULL_HANDLE) xr.destroyAnchor(_anchor);
        _anchor = XR_NULL_HANDLE;
        _refusesAnchor = true;
        return;
    }
    xr.destroySpace(_space);
    _space = tied;
}

void OpenXrSession::handleEvents()
{
    for (int i = 0; i < kMostEvents; ++i)
    {
        XrEventDataBuffer event{};
        event.type = XR_TYPE_EVENT_DATA_BUFFER;
        const XrResult result = _instance->functions().pollEvent(_instance->handle(), &event);
        _instance->check(result, "xrPollEvent");
        if (result == XR_EVENT_UNAVAILABLE) return;
        if (event.type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED)
        {
            const auto change = as<XrEventDataSessionStateChanged>(event);
            if (change.session == _session) handleState(change.state);
        }
        else if (event.type == XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING)
            throw OpenXrError(
                runtime() + " is going away; " + _instance->without() + " until it is back", true);
        else if (event.type == XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING)
        {
            const auto change = as<XrEventDataReferenceSpaceChangePending>(event);
            const bool isOurs =
                change.session == _session && change.referenceSpaceType == _spaceType;
            if (isOurs && _anchor == XR_NULL_HANDLE) tellRecentred();
        }
    }
}

void OpenXrSession::tellRecentred()
{
    const std::string text = "openxr: " + runtime() + " moves the origin of its " +
                             spaceName(_spaceType) +
                             " space: the calibration of hands is no longer valid";
    OpenXrLending::one().setRecentred(text);
    _say(text);
}

void OpenXrSession::handleState(XrSessionState state)
{
    const OpenXrFunctions& xr = _instance->functions();
    switch (state)
    {
    case XR_SESSION_STATE_READY:
    {
        XrSessionBeginInfo info{};
        info.type = XR_TYPE_SESSION_BEGIN_INFO;
        info.primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
        _instance->check(xr.beginSession(_session, &info), "xrBeginSession");
        _running = true;
        break;
    }
    case XR_SESSION_STATE_STOPPING:
        _running = false;
        _instance->check(xr.endSession(_session), "xrEndSession");
        _say("openxr: " + runtime() + " stopped the session; " + _instance->without() +
             " until it goes on");
        break;
    case XR_SESSION_STATE_LOSS_PENDING:
        throw OpenXrError(
            runtime() + " loses the session; " + _instance->without() + " until it is back", true);
    case XR_SESSION_STATE_EXITING:
        throw OpenXrError(runtime() + " ended the session; " + _instance->without() +
                              (_instance->has(XR_MND_HEADLESS_EXTENSION_NAME)
                                   ? ". Set the hand source again to begin another"
                                   : ". Start the program again to begin another"),
                          false);
    default:
        break;
    }
}

void OpenXrSession::locateAt(XrTime time, HandFrame& frame)
{
    frame.hands.clear();
    if (!_running || !_instance->tracksHands()) return;
    for (int id = 0; id < static_cast<int>(_trackers.size()); ++id)
    {
        Hand hand;
        hand.id = id;
        if (locateHand(id, time, 0, hand)) frame.hands.push_back(hand);
    }
}

void OpenXrSession::locate(HandFrame& frame, double ahead_s)
{
    frame.hands.clear();
    if (!_running || !_instance->tracksHands()) return;
    const XrTime now = _instance->now();
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
    const XrTime now = _instance->now();
    const auto ahead = _refusesLaterHead ? 0 : static_cast<XrDuration>(std::llround(1e9 * ahead_s));
    XrSpaceLocation location{};
    location.type = XR_TYPE_SPACE_LOCATION;
    const OpenXrFunctions& xr = _instance->functions();
    XrResult result = xr.locateSpace(_view, _space, now + ahead, &location);
    if (result == XR_ERROR_TIME_INVALID && ahead > 0)
    {
        _refusesLaterHead = true;
        _say("openxr: " + runtime() + " doesn't predict the head (" + resultName(result) +
             "): its present pose is used. prediction=kalman predicts it");
        result = xr.locateSpace(_view, _space, now, &location);
    }
    if (result == XR_ERROR_SESSION_LOST || result == XR_ERROR_INSTANCE_LOST)
        _instance->check(result, "xrLocateSpace");
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
    // Also false for NaN.
    head.isTracked = place.norm() < kFarthest_m && std::abs(turn.norm() - 1.0) < 1e-2;
    if (head.isTracked) head.pose = headPose(place, turn);
}

XrResult OpenXrSession::askRuntime(int id, XrTime time, XrHandJointLocationsEXT& locations) const
{
    XrHandJointsLocateInfoEXT info{};
    info.type = XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT;
    info.baseSpace = _space;
    info.time = time;
    return _instance->functions().locateHandJoints(
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
        _say("openxr: " + runtime() + " doesn't predict hands (" + resultName(result) +
             "): their present poses are used, and felt late. prediction=kalman predicts them");
        result = askRuntime(id, now, locations);
    }
    if (result == XR_ERROR_SESSION_LOST || result == XR_ERROR_INSTANCE_LOST)
        _instance->check(result, "xrLocateHandJointsEXT");
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
