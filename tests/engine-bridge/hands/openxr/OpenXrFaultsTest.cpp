// Debian's loader and a runtime of the tests' own that lacks something, fails, or hangs.
#include "tests/engine-bridge/hands/openxr/OpenXrHands.h"
#include "tests/fake-openxr/FakeHands.h"

#include <cstdlib>
#include <cstring>

#include <dlfcn.h>

namespace midair::bridge
{

namespace
{

using OpenXrFaults = OpenXrHands;

/// What the runtime lacks, and the text.
TEST_F(OpenXrFaults, MissingLoader)
{
    options.loader = "libmidair_no_such_loader.so.1";
    EXPECT_EQ(
        message(),
        "openxr: the loader can't be loaded (libmidair_no_such_loader.so.1: cannot open shared "
        "object file: No such file or directory); no hands. Install libopenxr-loader1 and an "
        "OpenXR runtime");
    EXPECT_EQ(source->status(), said[0] + "; 0 frames with hands, 0 joints left out");
}

TEST_F(OpenXrFaults, LibraryThatIsNoLoader)
{
    options.loader = "libm.so.6";
    EXPECT_EQ(message(),
              "openxr: libm.so.6 is no OpenXR loader (it has no xrGetInstanceProcAddr); no hands");
}

TEST_F(OpenXrFaults, LoaderWithoutRuntime)
{
    setenv("XR_RUNTIME_JSON", "/nowhere/runtime.json", 1);
    EXPECT_EQ(
        message(),
        "openxr: the loader finds no OpenXR runtime (XR_ERROR_RUNTIME_UNAVAILABLE); no hands. "
        "Install one, such as Monado, or name its manifest in XR_RUNTIME_JSON");
}

TEST_F(OpenXrFaults, RuntimeWithoutHandTracking)
{
    FakeAccess()->extensions = {"XR_MND_headless", "XR_KHR_convert_timespec_time"};
    EXPECT_EQ(
        message(),
        "openxr: Fake XR 1.2.3 has no XR_EXT_hand_tracking; no hands. They take a runtime with "
        "XR_EXT_hand_tracking, XR_MND_headless and XR_KHR_convert_timespec_time, such as "
        "Monado");
}

TEST_F(OpenXrFaults, RuntimeWithoutHeadlessSessions)
{
    FakeAccess()->extensions = {"XR_EXT_hand_tracking", "XR_KHR_convert_timespec_time"};
    EXPECT_EQ(message(),
              "openxr: Fake XR 1.2.3 has no XR_MND_headless; no hands. They take a runtime with "
              "XR_EXT_hand_tracking, XR_MND_headless and XR_KHR_convert_timespec_time, such as "
              "Monado");
}

TEST_F(OpenXrFaults, RuntimeWithoutMostExtensions)
{
    FakeAccess()->extensions = {"XR_EXT_hand_tracking"};
    EXPECT_EQ(message(),
              "openxr: Fake XR 1.2.3 has no XR_MND_headless and XR_KHR_convert_timespec_time; no "
              "hands. They take a runtime with XR_EXT_hand_tracking, XR_MND_headless and "
              "XR_KHR_convert_timespec_time, such as Monado");
}

TEST_F(OpenXrFaults, HeadsetThatDoesntTrackHands)
{
    FakeAccess()->tracksHands = false;
    EXPECT_EQ(message(),
              "openxr: Fake XR 1.2.3: \"Fake headset\" doesn't track hands; no hands. It takes a "
              "headset or camera that does");
}

TEST_F(OpenXrFaults, RuntimeWithoutTheStageThatWasAskedFor)
{
    FakeAccess()->spaces = {XR_REFERENCE_SPACE_TYPE_LOCAL};
    options.space = OpenXrSpace::STAGE;
    EXPECT_EQ(message(),
              "openxr: Fake XR 1.2.3 has no stage space; no hands. openxr:?space=local takes the "
              "other one");
}

TEST_F(OpenXrFaults, SessionThatIsRefused)
{
    FakeAccess()->failures["xrCreateSession"] = XR_ERROR_RUNTIME_FAILURE;
    EXPECT_EQ(message(),
              "openxr: Fake XR 1.2.3: xrCreateSession: XR_ERROR_RUNTIME_FAILURE; no hands");
}

TEST_F(OpenXrFaults, ProgramThatHasAnInstanceOfItsOwn)
{
    void* loader = dlopen(options.loader.c_str(), RTLD_NOW | RTLD_LOCAL);
    ASSERT_TRUE(loader);
    const auto create = reinterpret_cast<PFN_xrCreateInstance>(dlsym(loader, "xrCreateInstance"));
    const auto destroy =
        reinterpret_cast<PFN_xrDestroyInstance>(dlsym(loader, "xrDestroyInstance"));
    XrInstanceCreateInfo info{};
    info.type = XR_TYPE_INSTANCE_CREATE_INFO;
    std::strcpy(info.applicationInfo.applicationName, "test");
    info.applicationInfo.apiVersion = XR_CURRENT_API_VERSION;
    XrInstance instance = XR_NULL_HANDLE;
    ASSERT_EQ(create(&info, &instance), XR_SUCCESS);
    EXPECT_EQ(
        message(),
        "openxr: this program has an OpenXR instance already, and the loader allows no second "
        "one (XR_ERROR_LIMIT_REACHED); no hands. Hand its session over: osgMidair::XrSession");
    destroy(instance);
}

TEST_F(OpenXrFaults, HandsComeOnceTheHeadsetIsConnected)
{
    show(1, handAt(1, kTip));
    FakeAccess()->failures["xrGetSystem"] = XR_ERROR_FORM_FACTOR_UNAVAILABLE;
    EXPECT_EQ(
        message(),
        "openxr: Fake XR 1.2.3 has no headset now (XR_ERROR_FORM_FACTOR_UNAVAILABLE); no hands "
        "until it is connected");
    FakeAccess()->failures.clear();
    EXPECT_TRUE(handsCome(1));
}

TEST_F(OpenXrFaults, HandsComeOnceTheRuntimesServiceRuns)
{
    show(1, handAt(1, kTip));
    FakeAccess()->failures["xrCreateInstance"] = XR_ERROR_RUNTIME_FAILURE;
    EXPECT_EQ(
        message(),
        "openxr: the runtime can't be reached (xrCreateInstance: XR_ERROR_RUNTIME_FAILURE); no "
        "hands. Is its service running?");
    FakeAccess()->failures.clear();
    EXPECT_TRUE(handsCome(1));
}

/// How a session is lost in mid-run, and found again.
TEST_F(OpenXrFaults, ALostSessionIsToldAndFoundAgain)
{
    show(1, handAt(1, kTip));
    open();
    ASSERT_TRUE(handsCome(1));
    FakeAccess()->failures = {{"xrLocateHandJointsEXT", XR_ERROR_SESSION_LOST},
                              {"xrCreateInstance", XR_ERROR_INSTANCE_LOST}};
    ASSERT_TRUE(framesUntil([&] { return !said.empty() && frame.hands.empty(); }));
    EXPECT_EQ(said[0],
              "openxr: Fake XR 1.2.3: xrLocateHandJointsEXT: XR_ERROR_SESSION_LOST; no hands until "
              "it is back");
    FakeAccess()->failures.clear();
    EXPECT_TRUE(handsCome(1));
    EXPECT_EQ(FakeAccess()->instances, 2);
}

TEST_F(OpenXrFaults, ASessionThatIsAboutToBeLostIsGivenUp)
{
    show(1, handAt(1, kTip));
    open();
    ASSERT_TRUE(handsCome(1));
    FakeAccess()->states = {XR_SESSION_STATE_LOSS_PENDING};
    ASSERT_TRUE(framesUntil([&] { return !said.empty(); }));
    EXPECT_EQ(said[0], "openxr: Fake XR 1.2.3 loses the session; no hands until it is back");
    EXPECT_TRUE(framesUntil([&] { return frame.hands.size() == 1 && FakeAccess()->begun == 2; }));
}

TEST_F(OpenXrFaults, AnInstanceThatIsAboutToBeLostIsGivenUp)
{
    show(1, handAt(1, kTip));
    open();
    ASSERT_TRUE(handsCome(1));
    FakeAccess()->otherEvent = XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING;
    ASSERT_TRUE(framesUntil([&] { return !said.empty(); }));
    EXPECT_EQ(said[0], "openxr: Fake XR 1.2.3 is going away; no hands until it is back");
    EXPECT_TRUE(framesUntil([&] { return frame.hands.size() == 1 && FakeAccess()->begun == 2; }));
}

TEST_F(OpenXrFaults, AStoppedSessionGoesOn)
{
    show(1, handAt(1, kTip));
    open();
    ASSERT_TRUE(handsCome(1));
    FakeAccess()->states = {XR_SESSION_STATE_STOPPING, XR_SESSION_STATE_IDLE};
    ASSERT_TRUE(framesUntil([&] { return !said.empty() && frame.hands.empty(); }));
    EXPECT_EQ(said[0], "openxr: Fake XR 1.2.3 stopped the session; no hands until it goes on");
    EXPECT_EQ(FakeAccess()->ended, 1);
    FakeAccess()->states = {XR_SESSION_STATE_READY};
    EXPECT_TRUE(handsCome(1));
    EXPECT_EQ(FakeAccess()->instances, 1);
    EXPECT_EQ(FakeAccess()->begun, 2);
}

TEST_F(OpenXrFaults, ASessionThatTheUserEndedStaysEnded)
{
    show(1, handAt(1, kTip));
    open();
    ASSERT_TRUE(handsCome(1));
    FakeAccess()->states = {XR_SESSION_STATE_STOPPING, XR_SESSION_STATE_EXITING};
    ASSERT_TRUE(framesUntil([&] { return said.size() == 2 && FakeAccess()->alive == 0; }));
    EXPECT_EQ(
        said[1],
        "openxr: Fake XR 1.2.3 ended the session; no hands. Set the hand source again to begin "
        "another");
    EXPECT_TRUE(frame.hands.empty());
    EXPECT_EQ(FakeAccess()->instances, 1);
}

TEST_F(OpenXrFaults, AFaultOfTheTrackerIsToldOnceAndPasses)
{
    show(1, handAt(1, kTip));
    open();
    ASSERT_TRUE(handsCome(1));
    FakeAccess()->failures["xrLocateHandJointsEXT"] = XR_ERROR_RUNTIME_FAILURE;
    ASSERT_TRUE(framesUntil([&] { return !said.empty() && frame.hands.empty(); }));
    FakeAccess()->failures.clear();
    EXPECT_TRUE(handsCome(1));
    EXPECT_EQ(said,
              std::vector<std::string>{"openxr: Fake XR 1.2.3: xrLocateHandJointsEXT: "
                                       "XR_ERROR_RUNTIME_FAILURE; no hands as long as that lasts"});
    EXPECT_EQ(FakeAccess()->instances, 1);
}

/// Would hang if a frame waited.
TEST_F(OpenXrFaults, NoFrameWaitsForARuntimeThatHangs)
{
    show(1, handAt(1, kTip));
    FakeAccess()->blocked = "xrCreateInstance";
    open();
    for (int i = 0; i < 100; ++i)
        EXPECT_FALSE(source->frameAt(0.0, frame));
    FakeAccess()->blocked.clear();
    ASSERT_TRUE(handsCome(1));
    FakeAccess()->blocked = "xrLocateHandJointsEXT";
    // What was known of a runtime that doesn't answer grows stale.
    EXPECT_TRUE(handsCome(0));
    FakeAccess()->blocked.clear();
    EXPECT_TRUE(handsCome(1));
}

} // namespace

} // namespace midair::bridge
