#include "engine-bridge/hands/openxr/OpenXrSession.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

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
    if (_space != XR_NULL_HANDLE) xr.destroySpace(_space);
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
    XrReferenceSpaceCreateInfo info{};
    info.type = XR_TYPE_REFERENCE_SPACE_CREATE_INFO;
    info.referenceSpaceType = _spaceType;
    info.poseInReferenceSpace.orientation.w = 1.0f;
    _instance.check(xr.createReferenceSpace(_session, &info, &_space), "xrCreateReferenceSpace");
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
