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

/// A session without pictures in which a runtime tracks both hands. One thread.
class OpenXrSession
{
public:
    /// Joints farther than this from the origin of the space, or with a larger radius or none, are
    /// taken as invalid.
    static constexpr double kFarthest_m = 100.0;
    static constexpr double kThickest_m = 0.1;

    using Say = std::function<void(const std::string&)>;

    /// Connects, which may take long. \a say gets what the user should know, again and again.
    /// Throws OpenXrError.
    OpenXrSession(const std::string& loader, OpenXrSpace space, Say say);
    ~OpenXrSession();
    OpenXrSession(const OpenXrSession&) = delete;
    OpenXrSession& operator=(const OpenXrSession&) = delete;

    const std::string& runtime() const { return _instance.runtime(); }
    bool isRunning() const { return _running; }

    /// Begins, ends and gives up the session as the runtime asks. Throws OpenXrError when it is
    /// over.
    void handleEvents();

    /// The hands that are tracked now, in the space. Joints that are no places in it, by flag or by
    /// value, have no valid position. Throws OpenXrError when the session is lost.
    void locate(HandFrame& frame);

    /// Joints that had a valid flag and an impossible value, so far.
    std::size_t jointsLeftOut() const { return _leftOut; }

private:
    void createSpace(OpenXrSpace space);
    void handleState(XrSessionState state);
    bool locateHand(int id, XrTime time, Hand& hand);
    void destroy();

    Say _say;
    OpenXrInstance _instance;
    XrSession _session = XR_NULL_HANDLE;
    XrSpace _space = XR_NULL_HANDLE;
    XrReferenceSpaceType _spaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
    std::array<XrHandTrackerEXT, 2> _trackers{}; ///< left, right
    bool _running = false;
    std::size_t _leftOut = 0;
};

} // namespace midair::bridge
