// A program's own session, handed over to the sources of hands and heads.
#include "engine-bridge/hands/openxr/OpenXrLoan.h"

#include "engine-bridge/heads/HeadOpening.h"
#include "haptics/base/InputError.h"
#include "tests/engine-bridge/hands/openxr/OpenXrHands.h"

#include <array>
#include <cstring>

#include <dlfcn.h>

namespace midair::bridge
{

namespace
{

/// What a program does that has a headset of its own.
struct Program
{
    Program()
    {
        void* loader = dlopen("libopenxr_loader.so.1", RTLD_NOW | RTLD_LOCAL);
        get = reinterpret_cast<PFN_xrGetInstanceProcAddr>(dlsym(loader, "xrGetInstanceProcAddr"));
    }
    ~Program() { end(); }

    template<typename F>
    F function(const char* name)
    {
        PFN_xrVoidFunction found = nullptr;
        get(instance, name, &found);
        return reinterpret_cast<F>(found);
    }

    XrResult makeInstance()
    {
        const std::array<const char*, 3> names = {
            "XR_EXT_hand_tracking", "XR_MND_headless", "XR_KHR_convert_timespec_time"};
        XrInstanceCreateInfo info{};
        info.type = XR_TYPE_INSTANCE_CREATE_INFO;
        std::strcpy(info.applicationInfo.applicationName, "program");
        info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
        info.enabledExtensionCount = static_cast<std::uint32_t>(names.size());
        info.enabledExtensionNames = names.data();
        return function<PFN_xrCreateInstance>("xrCreateInstance")(&info, &instance);
    }

    void makeSession()
    {
        XrSessionCreateInfo info{};
        info.type = XR_TYPE_SESSION_CREATE_INFO;
        info.systemId = 1;
        ASSERT_EQ(function<PFN_xrCreateSession>("xrCreateSession")(instance, &info, &session),
                  XR_SUCCESS);
        FakeAccess()->states.clear();
        FakeAccess()->states.push_back(XR_SESSION_STATE_READY);
        XrEventDataBuffer event{};
        event.type = XR_TYPE_EVENT_DATA_BUFFER;
        function<PFN_xrPollEvent>("xrPollEvent")(instance, &event);
        XrSessionBeginInfo begin{};
        begin.type = XR_TYPE_SESSION_BEGIN_INFO;
        begin.primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
        ASSERT_EQ(function<PFN_xrBeginSession>("xrBeginSession")(session, &begin), XR_SUCCESS);
    }

    void end()
    {
        if (session != XR_NULL_HANDLE) function<PFN_xrDestroySession>("xrDestroySession")(session);
        if (instance != XR_NULL_HANDLE)
            function<PFN_xrDestroyInstance>("xrDestroyInstance")(instance);
        session = XR_NULL_HANDLE;
        instance = XR_NULL_HANDLE;
    }

    OpenXrHandles handles() const
    {
        return {reinterpret_cast<void (*)()>(get), instance, session, nullptr};
    }

    PFN_xrGetInstanceProcAddr get = nullptr;
    XrInstance instance = XR_NULL_HANDLE;
    XrSession session = XR_NULL_HANDLE;
};

struct OpenXrLoans : OpenXrHands
{
    void TearDown() override
    {
        loan.reset();
        program.end();
        OpenXrLending::one().setRecentred({});
        OpenXrHands::TearDown();
    }

    /// The program makes its own, and hands it over.
    void handOver()
    {
        loan = std::make_unique<OpenXrLoan>();
        ASSERT_EQ(program.makeInstance(), XR_SUCCESS);
        program.makeSession();
        loan->lend(program.handles(), OpenXrSpace::BEST);
    }

    Program program;
    std::unique_ptr<OpenXrLoan> loan;
};

TEST_F(OpenXrLoans, HandsAndHeadComeOfTheProgramsSession)
{
    show(1, handAt(1, kTip));
    FakeAccess()->head = XrPosef{{0, 0, 0, 1}, {0.1F, 1.6F, 0.2F}};
    handOver();
    open(Eigen::Isometry3d::Identity());
    const auto head = openHead("openxr:?matrix=1 0 0 0  0 1 0 0  0 0 1 0  0 0 0 1");
    ASSERT_TRUE(handsCome(1));
    EXPECT_LT((frame.hands[0].joints[INDEX_TIP].position - kTip).norm(), 1e-6);
    Head seen;
    EXPECT_TRUE(eventually([&] { return head->headAt(0.0, seen); }));
    EXPECT_LT((seen.pose.translation() - Eigen::Vector3d(0.1, 1.6, 0.2)).norm(), 1e-6);
    EXPECT_EQ(FakeAccess()->instances, 1);
    EXPECT_EQ(source->status().find("openxr: Fake XR 1.2.3; "), 0u) << source->status();
}

TEST_F(OpenXrLoans, TheOrderDoesntMatter)
{
    show(1, handAt(1, kTip));
    open();
    ASSERT_TRUE(handsCome(1)); // the kit has the one instance
    XrInstance other = program.instance;
    EXPECT_EQ(program.makeInstance(), XR_ERROR_LIMIT_REACHED);
    program.instance = other;
    handOver();
    EXPECT_EQ(FakeAccess()->instances, 2);
    ASSERT_TRUE(framesUntil([] { return FakeAccess()->begun == 2; }));
    const int before = FakeAccess()->located;
    EXPECT_TRUE(
        framesUntil([&] { return FakeAccess()->located > before + 2 && frame.hands.size() == 1; }));
    // And back.
    loan.reset();
    program.end();
    EXPECT_TRUE(
        framesUntil([&] { return FakeAccess()->instances == 3 && frame.hands.size() == 1; }));
}

TEST_F(OpenXrLoans, NobodyWaitsForTheNextAttempt)
{
    options.retry_s = 60.0; // a loan waits 5 s for the kit's own connection to end
    show(1, handAt(1, kTip));
    open();
    ASSERT_TRUE(handsCome(1));
    ASSERT_NO_THROW(handOver());
    EXPECT_TRUE(framesUntil([&] { return FakeAccess()->begun == 2 && frame.hands.size() == 1; }));
}

TEST_F(OpenXrLoans, HandsAreLocatedTwice)
{
    show(1, handAt(1, kTip));
    handOver();
    open(Eigen::Isometry3d::Identity());
    HandFrame shown;
    EXPECT_FALSE(source->shownFrame(shown)) << "nobody knows when the frame is displayed";
    source->setHorizon(0.06);
    ASSERT_TRUE(handsCome(1));
    ASSERT_TRUE(framesUntil([] { return FakeAccess()->ahead == 60000000; }));
    const XrTime display = FakeState::now() + 22000000;
    {
        const FakeAccess fake;
        fake->speed = {0.0F, 0.0F, 0.3F};
        fake->start = display - 500000000; // half a second later they turn back
    }
    loan->setDisplayTime(display);
    ASSERT_TRUE(source->shownFrame(shown));
    ASSERT_EQ(shown.hands.size(), 1u);
    const Eigen::Vector3d moved(0.0, 0.0, 0.3 / M_PI);
    EXPECT_LT((shown.hands[0].joints[INDEX_TIP].position - kTip - moved).norm(), 1e-6);
}

TEST_F(OpenXrLoans, ThereIsOne)
{
    loan = std::make_unique<OpenXrLoan>();
    try
    {
        const OpenXrLoan second;
        ADD_FAILURE() << "there are two";
    }
    catch (const base::InputError& wrong)
    {
        EXPECT_STREQ(wrong.what(),
                     "openxr: this program has a session already, its own or a headset's view, "
                     "and OpenXR allows one");
    }
    EXPECT_THROW(loan->lend({}, OpenXrSpace::BEST), base::InputError);
    open();
    EXPECT_TRUE(framesUntil(
        [&] {
            return source->status().find(
                       "openxr: no session of the headset or of the program now") == 0;
        }))
        << source->status();
    EXPECT_EQ(FakeAccess()->instances, 0);
}

TEST_F(OpenXrLoans, AMovedSpaceEndsTheClaimOfCoincidence)
{
    handOver();
    open();
    EXPECT_EQ(OpenXrLending::one().recentred(), "");
    loan->tellRecentred();
    const std::string why = "openxr: Fake XR 1.2.3 moves the origin of its stage space: the "
                            "calibration of hands is no longer valid";
    EXPECT_EQ(OpenXrLending::one().recentred(), why);
    ASSERT_TRUE(framesUntil([&] { return !said.empty(); }));
    EXPECT_EQ(said[0], why);
}

} // namespace

} // namespace midair::bridge
