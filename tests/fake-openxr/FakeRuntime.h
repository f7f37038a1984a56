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
    std::deque<XrSessionState> states;            ///< the next events
    XrStructureType otherEvent = XR_TYPE_UNKNOWN; ///< one event of this type

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
