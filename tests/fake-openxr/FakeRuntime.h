#pragma once

#include <array>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <openxr/openxr.h>

using FakeHand = std::array<XrHandJointLocationEXT, XR_HAND_JOINT_COUNT_EXT>;

/// What a headset showed to an eye.
struct FakePicture
{
    int width = 0;
    int height = 0;
    std::vector<unsigned char> rgba; ///< from the lowest row on
    std::vector<float> depth;        ///< empty: none was given
    XrPosef pose{};                  ///< as it was said to be drawn for
    XrPosef truePose{};              ///< of the eye when it was displayed
    XrFovf fov{};
    double off_m = 0.0;   ///< from the pose drawn to the true one
    double off_rad = 0.0; ///< the same of the turn
};

/// What the fake OpenXR runtime is, what it answers, and what was asked of it.
struct FakeState
{
    std::vector<std::string> extensions = {
        "XR_EXT_hand_tracking", "XR_KHR_convert_timespec_time", "XR_MND_headless"};
    std::vector<XrReferenceSpaceType> spaces = {XR_REFERENCE_SPACE_TYPE_LOCAL,
                                                XR_REFERENCE_SPACE_TYPE_STAGE};
    bool tracksHands = true;
    std::map<std::string, XrResult> failures; ///< by function: what it returns instead of working
    std::string blocked; ///< a function that doesn't return as long as this is set

    std::array<std::optional<FakeHand>, 2> hands; ///< left, right; none: not tracked
    std::optional<XrPosef> head;                  ///< of the view space; none: not tracked
    /// Hands and head sway about where they are set, the fastest at \c start and every second from
    /// then on with this speed, m/s.
    XrVector3f speed{};
    XrTime start = 0;
    XrVector3f swayAt(XrTime time) const;         ///< how far they are from there
    static XrTime now();                          ///< the runtime's time
    std::deque<XrSessionState> states;            ///< the next events
    XrStructureType otherEvent = XR_TYPE_UNKNOWN; ///< one event of this type
    XrVector3f spaceMoved{};                      ///< of its space's origin; anchors stay
    int anchorsRefused = 0;                       ///< so often it sees too little for one

    /// With XR_KHR_opengl_enable: pictures of this size for each eye, which GLX contexts draw.
    int width = 200;
    int height = 240;
    std::vector<XrEnvironmentBlendMode> blendModes = {XR_ENVIRONMENT_BLEND_MODE_OPAQUE};
    bool hasPassthrough = false;          ///< of XR_FB_passthrough, if that is offered
    bool keepsPictures = true;            ///< false: they are not read
    bool isPaced = false;                 ///< frames come at 90 Hz, else as fast as they are drawn
    std::array<FakePicture, 2> pictures;  ///< left, right, of the last frame
    double largestOff_m = 0.0;            ///< of all frames so far
    int frames = 0;                       ///< that were ended, so far
    int framesDrawn = 0;                  ///< with a projection layer
    int roomLayers = 0;                   ///< of the last frame, of passthrough
    XrEnvironmentBlendMode blend{};       ///< of the last frame
    XrCompositionLayerFlags layerFlags{}; ///< of its projection layer
    bool isMutePressed = false;           ///< the menu's button
    /// Where the eye is at a time; they are 64 mm apart and canted by 5 degrees each.
    XrPosef eyeAt(int eye, XrTime time) const;
    static XrFovf fovOf(int eye);

    bool predicts = true;     ///< false: it refuses hands, and the head, of a later time
    XrDuration ahead = 0;     ///< how much later than it was the last hands were asked for
    XrDuration headAhead = 0; ///< the same of the head
    int headsLocated = 0;     ///< so far

    int instances = 0;                                         ///< made so far
    int located = 0;                                           ///< hands so far
    int begun = 0;                                             ///< sessions so far
    int ended = 0;                                             ///< by xrEndSession, so far
    int alive = 0;                                             ///< handles that were not destroyed
    XrReferenceSpaceType space = XR_REFERENCE_SPACE_TYPE_VIEW; ///< the last one made
    std::vector<std::string> misuse; ///< what the specification forbids, and was done
};

/// The runtime's state, locked; what a test changes is in force when this goes.
class FakeAccess
{
public:
    FakeAccess();
    ~FakeAccess();
    FakeAccess(const FakeAccess&) = delete;
    FakeAccess& operator=(const FakeAccess&) = delete;

    FakeState* operator->() const;
    FakeState& operator*() const;

    /// Until \a blocked isn't \a function.
    void waitWhileBlocked(const std::string& function);

private:
    std::unique_lock<std::mutex> _lock;
};
