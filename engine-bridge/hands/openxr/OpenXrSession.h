#pragma once

#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/openxr/OpenXrInstance.h"
#include "engine-bridge/hands/openxr/OpenXrTracker.h"

#include <array>
#include <cstddef>
#include <functional>
#include <string>

namespace midair::bridge
{

/// A session without rendering in which a runtime tracks both hands. To be used by one thread.
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

    /// The number of joints so far with a valid flag and an impossible value.
    std::size_t jointsLeftOut() const { return _leftOut; }

private:
    void createSpace(OpenXrSpace space);
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
    bool _refusesLater = false; ///< the runtime tells no hands of a later time
    std::size_t _leftOut = 0;
};

} // namespace midair::bridge
