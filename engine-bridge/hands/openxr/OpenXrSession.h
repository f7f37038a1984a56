#pragma once

#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/Head.h"
#include "engine-bridge/hands/openxr/OpenXrLending.h"
#include "engine-bridge/hands/openxr/OpenXrTracker.h"
#include "haptics/base/InputError.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

namespace midair::bridge
{

/// Thrown if OpenXR provides no hands or no picture; what() has the reason and a remedy.
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

/// OpenXR functions for tracking; valid as long as their instance.
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
    PFN_xrCreateSpatialAnchorMSFT createAnchor = nullptr; ///< null: the runtime has no anchors
    PFN_xrCreateSpatialAnchorSpaceMSFT createAnchorSpace = nullptr;
    PFN_xrDestroySpatialAnchorMSFT destroyAnchor = nullptr;
};

/// An instance of a runtime and its headset.
class OpenXrInstance
{
public:
    /// Purpose, which determines the required extensions.
    enum class Use
    {
        HANDS,  ///< hands are tracked without rendering
        PICTURE ///< a picture is drawn by OpenGL; hands are tracked if possible
    };

    /// Makes an instance. \a loader: file name of the loader's library, which is loaded. Throws
    /// OpenXrError.
    OpenXrInstance(const std::string& loader, Use use);
    /// Uses the program's instance, which the program keeps. Throws OpenXrError.
    explicit OpenXrInstance(const OpenXrHandles& handles);
    ~OpenXrInstance();
    OpenXrInstance(const OpenXrInstance&) = delete;
    OpenXrInstance& operator=(const OpenXrInstance&) = delete;

    const OpenXrFunctions& functions() const { return _functions; }
    XrInstance handle() const { return _instance; }
    XrSystemId system() const { return _system; }
    const std::string& runtime() const { return _runtime; } ///< name and version
    const std::string& without() const { return _without; } ///< missing feature: "no hands"
    bool isOwn() const { return _isOwn; }                   ///< it is destroyed with this object
    bool has(const char* extension) const { return _extensions.count(extension) > 0; }
    bool tracksHands() const { return _tracksHands; }
    /// The program loaded the loader before the kit, and may want an instance, too.
    bool isLoaderPrograms() const { return _isLoaderPrograms; }

    /// Throws OpenXrError if \a result of the function \a call is an error.
    void check(XrResult result, const char* call) const;
    /// Sets \a function to the function \a name. Throws OpenXrError if it doesn't exist.
    template<typename F>
    void load(const char* name, F& function) const
    {
        function = reinterpret_cast<F>(find(name));
    }

    /// Returns the runtime's present time. Without the time extension: that of the last setTime()
    /// plus the time elapsed since.
    XrTime now() const;
    /// Sets a time of the runtime that is about now.
    void setTime(XrTime time);
    /// Returns \a time on the steady clock; none without that extension.
    std::optional<double> steadyTime(XrTime time) const;

private:
    /// A time of the runtime with the matching time of the steady clock.
    struct KnownTime
    {
        std::atomic<XrTime> time{0};
        std::atomic<double> at_s{0.0};
    };

    PFN_xrVoidFunction find(const char* name) const;
    void loadLibrary(const std::string& loader);
    void create(Use use);
    void loadFunctions();
    void loadHandFunctions();
    void findSystem(Use use);

    OpenXrFunctions _functions;
    XrInstance _instance = XR_NULL_HANDLE;
    XrSystemId _system = XR_NULL_SYSTEM_ID;
    std::string _runtime = "the runtime";
    std::string _without = "no hands";
    std::set<std::string> _extensions; ///< in use
    bool _tracksHands = false;
    bool _isOwn = true;
    bool _isLoaderPrograms = false;
    KnownTime _known;
};

/// Returns "XR_ERROR_RUNTIME_FAILURE" and so on.
std::string resultName(XrResult result);

/// A session in which a runtime tracks both hands and the head. To be used by one thread, or
/// through OpenXrLending.
class OpenXrSession
{
public:
    /// Joints farther than kFarthest_m from the origin of the space, or with a radius of 0 or over
    /// kThickest_m, count as invalid.
    static constexpr double kFarthest_m = 100.0;
    static constexpr double kThickest_m = 0.1;

    using Say = std::function<void(const std::string&)>;

    /// Connects without rendering, which may take long. \a say receives messages for the user,
    /// possibly repeated. Throws OpenXrError.
    OpenXrSession(const std::string& loader, OpenXrSpace space, Say say);
    /// Connects through \a instance. \a binding: graphics binding, an OpenXR structure. Throws
    /// OpenXrError.
    OpenXrSession(std::shared_ptr<OpenXrInstance> instance,
                  const void* binding,
                  OpenXrSpace space,
                  Say say);
    /// Uses the program's session, which counts as running; the program also handles its events.
    /// Throws OpenXrError.
    OpenXrSession(const OpenXrHandles& handles, OpenXrSpace space, Say say);
    ~OpenXrSession();
    OpenXrSession(const OpenXrSession&) = delete;
    OpenXrSession& operator=(const OpenXrSession&) = delete;

    const OpenXrInstance& instance() const { return *_instance; }
    const std::string& runtime() const { return _instance->runtime(); }
    XrSession handle() const { return _session; }
    XrSpace space() const { return _space; }
    bool isRunning() const { return _running; }
    /// Sets whether the program's session runs.
    void setRunning(bool isRunning) { _running = isRunning; }
    /// See OpenXrInstance::setTime().
    void setTime(XrTime time) { _instance->setTime(time); }

    /// Anchors its space to the room at \a place (a pose in it), so that it stays when the runtime
    /// moves its origin: at the first \a time (of the runtime, about now) at which a runtime with
    /// anchors can. Does nothing once it is anchored.
    void anchor(const Eigen::Isometry3d& place, XrTime time);

    /// Handles the runtime's events: begins and ends the session on request. Throws OpenXrError
    /// when the session is over.
    void handleEvents();

    /// Stores the hands \a ahead_s (>= 0) from now, as predicted by the runtime, in \a frame, in
    /// the session's space. A runtime that refuses such a time is asked for the present hands from
    /// then on, which is reported. Joints with an invalid flag or an impossible value have no valid
    /// position. Throws OpenXrError when the session is lost.
    void locate(HandFrame& frame, double ahead_s = 0.0);

    /// Stores the head (the runtime's view space) \a ahead_s (>= 0) from now in \a head, in the
    /// session's space, if its position and orientation are known and its position is tracked, not
    /// inferred; otherwise isTracked is false. See also locate().
    void locateHead(Head& head, double ahead_s = 0.0);

    /// Stores the hands at the runtime's \a time in \a frame.
    void locateAt(XrTime time, HandFrame& frame);

    /// Reports that the runtime has moved the origin of its space.
    void tellRecentred();

    /// Number of joints so far with a valid flag and an impossible value.
    std::size_t jointsLeftOut() const { return _leftOut; }

private:
    void begin(OpenXrSpace space);
    void createSpace(OpenXrSpace space);
    XrSpace makeSpace(XrReferenceSpaceType type);
    void handleState(XrSessionState state);
    bool locateHand(int id, XrTime now, XrDuration ahead, Hand& hand);
    XrResult askRuntime(int id, XrTime time, XrHandJointLocationsEXT& locations) const;
    void destroy();

    Say _say;
    const std::shared_ptr<OpenXrInstance> _instance;
    XrSession _session = XR_NULL_HANDLE;
    XrSpace _space = XR_NULL_HANDLE;
    bool _isSpaceOwn = true;
    XrSpatialAnchorMSFT _anchor = XR_NULL_HANDLE;
    bool _refusesAnchor = false;
    XrReferenceSpaceType _spaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
    std::array<XrHandTrackerEXT, 2> _trackers{}; ///< left, right
    std::atomic<bool> _running{false};
    XrSpace _view = XR_NULL_HANDLE; ///< the head's; created on demand
    bool _refusesLater = false;     ///< the runtime doesn't predict hands
    bool _refusesLaterHead = false; ///< nor the head
    std::size_t _leftOut = 0;
};

} // namespace midair::bridge
