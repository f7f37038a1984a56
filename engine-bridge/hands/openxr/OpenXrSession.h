#pragma once

#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/Head.h"
#include "engine-bridge/hands/openxr/OpenXrTracker.h"
#include "haptics/base/InputError.h"

#include <array>
#include <cstddef>
#include <functional>
#include <string>

#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

namespace midair::bridge
{

/// Thrown when OpenXR gives no hands; what() says what is missing and what would be right.
class OpenXrError : public base::InputError
{
public:
    OpenXrError(const std::string& what, bool mayPass) :
        base::InputError("openxr: " + what),
        _mayPass(mayPass)
    {
    }

    /// Returns true if trying again may succeed (a headset may be switched on, a session was lost).
    bool mayPass() const { return _mayPass; }

private:
    bool _mayPass;
};

/// The OpenXR functions that hand tracking needs; valid as long as their instance.
struct OpenXrFunctions
{
    PFN_xrGetInstanceProcAddr getInstanceProcAddr = nullptr;
    PFN_xrDestroyInstance destroyInstance = nullptr;
    PFN_xrGetInstanceProperties getInstanceProperties = nullptr;
    PFN_xrGetSystem getSystem = nullptr;
    PFN_xrGetSystemProperties getSystemProperties = nullptr;
    PFN_xrPollEvent pollEvent = nullptr;
    PFN_xrCreateSession createSession = nullptr;
    PFN_xrDestroySession destroySession = nullptr;
    PFN_xrBeginSession beginSession = nullptr;
    PFN_xrEndSession endSession = nullptr;
    PFN_xrEnumerateReferenceSpaces enumerateReferenceSpaces = nullptr;
    PFN_xrCreateReferenceSpace createReferenceSpace = nullptr;
    PFN_xrDestroySpace destroySpace = nullptr;
    PFN_xrLocateSpace locateSpace = nullptr;
    PFN_xrConvertTimespecTimeToTimeKHR convertTimespecTimeToTime = nullptr;
    PFN_xrCreateHandTrackerEXT createHandTracker = nullptr;
    PFN_xrDestroyHandTrackerEXT destroyHandTracker = nullptr;
    PFN_xrLocateHandJointsEXT locateHandJoints = nullptr;
};

/// An instance of a runtime that can track hands without rendering, and its headset; the
/// constructor loads the loader's library.
class OpenXrInstance
{
public:
    /// \a loader: file name of the loader's library. Throws OpenXrError.
    explicit OpenXrInstance(const std::string& loader);
    ~OpenXrInstance();
    OpenXrInstance(const OpenXrInstance&) = delete;
    OpenXrInstance& operator=(const OpenXrInstance&) = delete;

    const OpenXrFunctions& functions() const { return _functions; }
    XrInstance handle() const { return _instance; }
    XrSystemId system() const { return _system; }
    const std::string& runtime() const { return _runtime; } ///< name and version

    /// Throws OpenXrError if \a result, of the function \a call, is an error.
    void check(XrResult result, const char* call) const;

    /// The runtime's time now.
    XrTime now() const;

private:
    void loadLibrary(const std::string& loader);
    void create();
    void loadFunctions();
    void findSystem();
    template<typename F>
    void load(const char* name, F& function) const;

    OpenXrFunctions _functions;
    XrInstance _instance = XR_NULL_HANDLE;
    XrSystemId _system = XR_NULL_SYSTEM_ID;
    std::string _runtime = "the runtime";
};

/// "XR_ERROR_RUNTIME_FAILURE" and the like.
std::string resultName(XrResult result);

/// A session without rendering in which a runtime tracks both hands and the head. To be used by one
/// thread.
class OpenXrSession
{
public:
    /// Joints farther than kFarthest_m from the origin of the space, or with a radius of 0 or over
    /// kThickest_m, count as invalid.
    static constexpr double kFarthest_m = 100.0;
    static constexpr double kThickest_m = 0.1;

    using Say = std::function<void(const std::string&)>;

    /// Connects, which may take long. \a say gets messages for the user, which may repeat. Throws
    /// OpenXrError.
    OpenXrSession(const std::string& loader, OpenXrSpace space, Say say);
    ~OpenXrSession();
    OpenXrSession(const OpenXrSession&) = delete;
    OpenXrSession& operator=(const OpenXrSession&) = delete;

    const std::string& runtime() const { return _instance.runtime(); }
    bool isRunning() const { return _running; }

    /// Handles the runtime's events: begins and ends the session as it asks. Throws OpenXrError
    /// when the session is over.
    void handleEvents();

    /// Puts the hands that are tracked \a ahead_s (>= 0) from now into \a frame, in the session's
    /// space: the runtime predicts them. One that refuses such a time is asked for those of now,
    /// from then on, which is told. Joints with an invalid flag or an impossible value have no
    /// valid position. Throws OpenXrError when the session is lost.
    void locate(HandFrame& frame, double ahead_s = 0.0);

    /// Puts the head (the runtime's view space) \a ahead_s (>= 0) from now into \a head, in the
    /// session's space, if its place and turn are known and its place is tracked, which an inferred
    /// one isn't; else it has isTracked false. As locate() otherwise.
    void locateHead(Head& head, double ahead_s = 0.0);

    /// The number of joints so far with a valid flag and an impossible value.
    std::size_t jointsLeftOut() const { return _leftOut; }

private:
    void createSpace(OpenXrSpace space);
    XrSpace makeSpace(XrReferenceSpaceType type);
    void handleState(XrSessionState state);
    bool locateHand(int id, XrTime now, XrDuration ahead, Hand& hand);
    XrResult askRuntime(int id, XrTime time, XrHandJointLocationsEXT& locations) const;
    void destroy();

    Say _say;
    OpenXrInstance _instance;
    XrSession _session = XR_NULL_HANDLE;
    XrSpace _space = XR_NULL_HANDLE;
    XrReferenceSpaceType _spaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
    std::array<XrHandTrackerEXT, 2> _trackers{}; ///< left, right
    bool _running = false;
    XrSpace _view = XR_NULL_HANDLE; ///< the head's; none before it is asked for
    bool _refusesLater = false;     ///< the runtime tells no hands of a later time
    bool _refusesLaterHead = false; ///< nor the head
    std::size_t _leftOut = 0;
};

} // namespace midair::bridge
