// Debian's loader and a runtime of the tests' own that works.
#include "tests/engine-bridge/hands/openxr/OpenXrHands.h"
#include "tests/fake-openxr/FakeHands.h"

#include <limits>

namespace midair::bridge
{

namespace
{

TEST_F(OpenXrHands, AreWhereTheRuntimeSeesThemTurnedUpright)
{
    show(1, handAt(1, kTip));
    open();
    ASSERT_TRUE(handsCome(1));
    EXPECT_EQ(frame.time_s, 7.0);
    const Hand& hand = frame.hands[0];
    EXPECT_EQ(hand.id, 1);
    EXPECT_LT((hand.joints[INDEX_TIP].position - Eigen::Vector3d(0.1, 0.3, 1.2)).norm(), 1e-6);
    EXPECT_NEAR(hand.joints[INDEX_TIP].radius_m, 0.007, 1e-6);
    // The back of the hand, y of the palm, is up.
    EXPECT_LT((hand.joints[PALM].orientation * Eigen::Vector3d::UnitY() - Eigen::Vector3d::UnitZ())
                  .norm(),
              1e-6);
    EXPECT_EQ(handCapsules(frame).size(), static_cast<std::size_t>(kHandBones));
    EXPECT_EQ(said, std::vector<std::string>());
    const std::string status = source->status();
    EXPECT_EQ(status.find("openxr: Fake XR 1.2.3; "), 0u) << status;
    EXPECT_NE(status.find(" frames with hands, 0 joints left out"), std::string::npos) << status;
}

TEST_F(OpenXrHands, ArePlacedByAMatrixOfOnesOwn)
{
    show(0, handAt(0, kTip));
    open(Eigen::Isometry3d(Eigen::Translation3d(0, 0, 1)));
    ASSERT_TRUE(handsCome(1));
    EXPECT_EQ(frame.hands[0].id, 0);
    EXPECT_LT((frame.hands[0].joints[INDEX_TIP].position - Eigen::Vector3d(0.1, 1.2, 0.7)).norm(),
              1e-6);
}

TEST_F(OpenXrHands, AreAskedForTheTimeToWhichTheyArePredicted)
{
    show(1, handAt(1, kTip));
    open();
    ASSERT_TRUE(handsCome(1));
    EXPECT_EQ(FakeAccess()->ahead, 0);
    EXPECT_GE(frame.hands[0].age_s, 0.0);
    EXPECT_LE(frame.hands[0].age_s, OpenXrTracker::kStale_s);
    EXPECT_TRUE(source->setHorizon(0.047));
    EXPECT_TRUE(framesUntil([] { return FakeAccess()->ahead == 47000000; }));
    for (const double none_s : {-1.0, std::numeric_limits<double>::quiet_NaN()})
    {
        source->setHorizon(0.047);
        ASSERT_TRUE(framesUntil([] { return FakeAccess()->ahead == 47000000; }));
        source->setHorizon(none_s);
        EXPECT_TRUE(framesUntil([] { return FakeAccess()->ahead == 0; })) << none_s;
    }
    EXPECT_EQ(said, std::vector<std::string>());
}

TEST_F(OpenXrHands, AreThoseOfNowWhereTheRuntimeTellsNoLaterOnes)
{
    FakeAccess()->predicts = false;
    show(1, handAt(1, kTip));
    open();
    source->setHorizon(0.05);
    ASSERT_TRUE(handsCome(1));
    ASSERT_TRUE(framesUntil([&] { return FakeAccess()->located > 10 && !frame.hands.empty(); }));
    EXPECT_EQ(said,
              std::vector<std::string>{
                  "openxr: Fake XR 1.2.3 doesn't predict hands (XR_ERROR_TIME_INVALID): their "
                  "present poses are used, and felt late. prediction=kalman predicts them"});
}

TEST_F(OpenXrHands, ComeAndGoWithTheTracker)
{
    open();
    ASSERT_TRUE(framesUntil([] { return FakeAccess()->located >= 4; }));
    EXPECT_TRUE(frame.hands.empty());
    show(0, handAt(0, kTip));
    show(1, handAt(1, kTip));
    ASSERT_TRUE(handsCome(2));
    FakeAccess()->hands[1].reset();
    ASSERT_TRUE(handsCome(1));
    EXPECT_EQ(frame.hands[0].id, 0);
    FakeAccess()->hands[0].reset();
    ASSERT_TRUE(handsCome(0));
    EXPECT_EQ(said, std::vector<std::string>());
}

TEST_F(OpenXrHands, JointsThatAreNotValidAreNotBelievedWhateverTheyHold)
{
    Hand hand = handAt(1, kTip);
    HandJoint& tip = hand.joints[INDEX_TIP];
    tip.positionValid = tip.orientationValid = false;
    tip.position.setConstant(std::numeric_limits<double>::quiet_NaN());
    show(1, hand);
    open();
    ASSERT_TRUE(handsCome(1));
    EXPECT_FALSE(frame.hands[0].joints[INDEX_TIP].positionValid);
    EXPECT_FALSE(frame.hands[0].joints[INDEX_TIP].orientationValid);
    EXPECT_EQ(handCapsules(frame).size(), static_cast<std::size_t>(kHandBones - 1));
    EXPECT_EQ(said, std::vector<std::string>()); // a tracker may well not see a joint
}

TEST_F(OpenXrHands, ImpossibleJointsAreLeftOutAndToldOnce)
{
    const double nan = std::numeric_limits<double>::quiet_NaN();
    Hand hand = handAt(1, kTip);
    hand.joints[THUMB_TIP].radius_m = -0.01;
    hand.joints[INDEX_TIP].position.y() = nan;
    hand.joints[MIDDLE_TIP].position.x() = std::numeric_limits<double>::infinity();
    hand.joints[RING_TIP].radius_m = nan;
    hand.joints[LITTLE_TIP].radius_m = 0.2;
    hand.joints[LITTLE_DISTAL].position.z() = 1000.0;
    hand.joints[PALM].orientation.coeffs().setConstant(nan);
    hand.joints[WRIST].orientation.coeffs().setZero();
    show(1, hand);
    open();
    ASSERT_TRUE(handsCome(1));
    ASSERT_TRUE(framesUntil([&] { return FakeAccess()->located > 10 && !frame.hands.empty(); }));
    const auto& joints = frame.hands[0].joints;
    for (const int joint : {THUMB_TIP, INDEX_TIP, MIDDLE_TIP, RING_TIP, LITTLE_TIP, LITTLE_DISTAL})
        EXPECT_FALSE(joints[static_cast<std::size_t>(joint)].positionValid) << jointName(joint);
    EXPECT_TRUE(joints[PALM].positionValid);
    EXPECT_FALSE(joints[PALM].orientationValid);
    EXPECT_FALSE(joints[WRIST].orientationValid);
    for (const HandJoint& joint : joints)
    {
        EXPECT_TRUE(joint.position.allFinite());
        EXPECT_TRUE(joint.orientation.coeffs().allFinite());
        EXPECT_GE(joint.radius_m, 0.0); // false for NaN
    }
    // Four fingertips take a bone each, the little finger's last two joints two.
    EXPECT_EQ(handCapsules(frame).size(), static_cast<std::size_t>(kHandBones - 6));
    ASSERT_EQ(said.size(), 1u);
    EXPECT_EQ(said[0].find("openxr: Fake XR 1.2.3 gives an impossible thumb tip of the right hand "
                           "(position "),
              0u)
        << said[0];
    EXPECT_NE(said[0].find(" m, radius -0.01 m); positions within 100 m and radii over 0, up to "
                           "0.1 m are believed, other joints left out"),
              std::string::npos)
        << said[0];
    EXPECT_EQ(source->status().find(" 0 joints left out"), std::string::npos);
}

TEST_F(OpenXrHands, AHandWithoutAnyPlaceIsNone)
{
    Hand hand = handAt(1, kTip);
    for (HandJoint& joint : hand.joints)
        joint.radius_m = 0.0;
    show(1, hand);
    open();
    ASSERT_TRUE(framesUntil([&] { return !said.empty() && FakeAccess()->located > 10; }));
    EXPECT_TRUE(frame.hands.empty());
}

TEST_F(OpenXrHands, TheStageIsTakenWhereThereIsOne)
{
    show(1, handAt(1, kTip));
    open();
    ASSERT_TRUE(handsCome(1));
    EXPECT_EQ(FakeAccess()->space, XR_REFERENCE_SPACE_TYPE_STAGE);
    source.reset();
    options.space = OpenXrSpace::LOCAL;
    open();
    ASSERT_TRUE(handsCome(1));
    EXPECT_EQ(FakeAccess()->space, XR_REFERENCE_SPACE_TYPE_LOCAL);
    source.reset();
    options.space = OpenXrSpace::BEST;
    FakeAccess()->spaces = {XR_REFERENCE_SPACE_TYPE_LOCAL};
    open();
    ASSERT_TRUE(handsCome(1));
    EXPECT_EQ(FakeAccess()->space, XR_REFERENCE_SPACE_TYPE_LOCAL);
}

TEST_F(OpenXrHands, AMovedOriginIsTold)
{
    show(1, handAt(1, kTip));
    open();
    ASSERT_TRUE(handsCome(1));
    FakeAccess()->otherEvent = XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING;
    ASSERT_TRUE(framesUntil([&] { return !said.empty(); }));
    EXPECT_EQ(said[0],
              "openxr: Fake XR 1.2.3 moves the origin of its stage space: the calibration of hands "
              "is no longer valid");
}

TEST_F(OpenXrHands, EachOfTwoSourcesHasAHorizonOfItsOwn)
{
    show(1, handAt(1, kTip));
    open();
    OpenXrHandSource other(options);
    source->setHorizon(0.047);
    other.setHorizon(0.011);
    HandFrame seen;
    for (const XrDuration ahead : {47000000, 11000000, 47000000, 11000000})
        EXPECT_TRUE(
            framesUntil([&] { return other.frameAt(7.0, seen) && FakeAccess()->ahead == ahead; }))
            << ahead;
}

TEST_F(OpenXrHands, TwoSourcesShareTheProgramsOneInstance)
{
    show(1, handAt(1, kTip));
    open();
    ASSERT_TRUE(handsCome(1));
    OpenXrHandSource other(options, Eigen::Isometry3d::Identity());
    HandFrame seen;
    EXPECT_TRUE(framesUntil([&] { return other.frameAt(0.0, seen); }));
    EXPECT_LT((seen.hands.at(0).joints[INDEX_TIP].position - kTip).norm(), 1e-6);
    EXPECT_EQ(FakeAccess()->instances, 1);
    source.reset();
    open();
    ASSERT_TRUE(handsCome(1));
    EXPECT_EQ(FakeAccess()->instances, 1);
}

TEST_F(OpenXrHands, ASourceWithOtherOptionsWaitsForTheFirstToEnd)
{
    show(1, handAt(1, kTip));
    open();
    ASSERT_TRUE(handsCome(1));
    std::unique_ptr<OpenXrHandSource> first = std::move(source);
    options.space = OpenXrSpace::LOCAL;
    EXPECT_EQ(message(),
              "openxr: another hand source of this program follows OpenXR with other options; no "
              "hands until it ends");
    first.reset();
    EXPECT_TRUE(handsCome(1));
}

} // namespace

} // namespace midair::bridge
