#include "engine-bridge/hands/HandSource.h"

#include "haptics/base/InputError.h"
#include "tests/engine-bridge/hands/WrittenHands.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <locale>
#include <set>
#include <sstream>

#include <gtest/gtest.h>
#include <unistd.h>

namespace midair::bridge
{

namespace
{

HandFrame frameWith(double time_s, const Eigen::Vector3d& tip)
{
    HandFrame frame;
    frame.time_s = time_s;
    frame.hands.push_back(openHandWithIndexTipAt(1, tip, Eigen::Quaterniond::Identity()));
    return frame;
}

Eigen::Vector3d indexTip(const HandFrame& frame)
{
    return frame.hands.at(0).joints[INDEX_TIP].position;
}

std::string recording(const std::vector<HandFrame>& frames)
{
    std::ostringstream out;
    writeHandRecording(out, frames);
    return out.str();
}

RecordedHandSource source(const std::string& text, bool loop = false)
{
    std::istringstream in(text);
    return RecordedHandSource(in, "hands.csv", loop);
}

std::string sourceError(const std::string& text)
{
    try
    {
        source(text);
    }
    catch (const base::InputError& error)
    {
        return error.what();
    }
    return {};
}

TEST(Hand, OpenHandIsAnAdultsWithEveryBone)
{
    HandFrame frame;
    frame.hands.push_back(openHand(1, Eigen::Isometry3d::Identity()));
    const std::vector<HandCapsule> capsules = handCapsules(frame);
    ASSERT_EQ(capsules.size(), static_cast<std::size_t>(kHandBones));
    std::set<std::string> names;
    for (const HandCapsule& capsule : capsules)
    {
        names.insert(boneName(capsule.bone));
        EXPECT_GT((capsule.shape.a - capsule.shape.b).norm(), 0.01) << boneName(capsule.bone);
        EXPECT_GT(capsule.shape.radius_m, 0.005) << boneName(capsule.bone);
    }
    EXPECT_EQ(names.size(), capsules.size());
    EXPECT_EQ(names.count("index distal to index tip"), 1u);
    const auto& joints = frame.hands[0].joints;
    const double length = (joints[WRIST].position - joints[MIDDLE_TIP].position).norm();
    EXPECT_NEAR(length, 0.19, 0.02); // wrist to tip of an adult
    EXPECT_LT(joints[THUMB_TIP].position.x(),
              0.0); // a right hand, seen from above, has its thumb to the left
    EXPECT_GT(openHand(0, Eigen::Isometry3d::Identity()).joints[THUMB_TIP].position.x(), 0.0);
}

TEST(Hand, IndexTipIsWhereItWasAskedFor)
{
    const Eigen::Vector3d tip(0.01, -0.2, 0.3);
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(1.0, Eigen::Vector3d(1, 1, 0).normalized()));
    const Hand hand = openHandWithIndexTipAt(0, tip, turn);
    EXPECT_LT((hand.joints[INDEX_TIP].position - tip).norm(), 1e-15);
    EXPECT_LT(hand.joints[PALM].orientation.angularDistance(turn), 1e-12);
}

TEST(Hand, AnImpossibleJointIsLeftOutAndNamed)
{
    Hand hand = openHand(1, Eigen::Isometry3d::Identity());
    EXPECT_EQ(leaveOutImpossible(hand), "");
    hand.joints[INDEX_TIP].radius_m = 1e30;
    hand.joints[PALM].position.x() = std::numeric_limits<double>::infinity();
    hand.joints[WRIST].positionValid = false;
    hand.joints[WRIST].radius_m = 7.0; // not tracked, so it says nothing
    hand.joints[LITTLE_TIP].position.x() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(leaveOutImpossible(hand),
              "the palm of hand 1 is left out: it is inf m away, should be within 1000 m");
    EXPECT_FALSE(hand.joints[PALM].positionValid);
    EXPECT_FALSE(hand.joints[INDEX_TIP].positionValid);
    EXPECT_TRUE(hand.joints[INDEX_DISTAL].positionValid);
    EXPECT_EQ(leaveOutImpossible(hand), "") << "left out";
    hand.joints[INDEX_TIP].positionValid = true;
    EXPECT_EQ(leaveOutImpossible(hand),
              "the index tip of hand 1 is left out: its radius is 1e+30 m, should be up to 0.1 m");
}

TEST(Hand, AJointWithoutAValidPositionMakesNoCapsule)
{
    HandFrame frame = frameWith(0.0, Eigen::Vector3d::Zero());
    HandJoint& distal = frame.hands[0].joints[INDEX_DISTAL];
    distal.orientationValid = false; // a position alone is enough
    EXPECT_EQ(handCapsules(frame).size(), static_cast<std::size_t>(kHandBones));
    distal.positionValid = false; // and takes the bones on both sides of it along
    EXPECT_EQ(handCapsules(frame).size(), static_cast<std::size_t>(kHandBones - 2));
    distal.positionValid = true;
    distal.position.x() = NAN;
    EXPECT_EQ(handCapsules(frame).size(), static_cast<std::size_t>(kHandBones - 2));
}

TEST(RecordedHandSource, ReadsWhatWasWritten)
{
    HandFrame first = frameWith(0.0, Eigen::Vector3d(0.1, 0.2, 0.3));
    first.hands[0].joints[RING_TIP].positionValid = false;
    first.hands[0].joints[PALM].orientation = Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5);
    const RecordedHandSource played =
        source(recording({first, frameWith(0.02, Eigen::Vector3d(0.1, 0.2, 0.4))}));
    ASSERT_EQ(played.frames().size(), 2u);
    const Hand& hand = played.frames()[0].hands.at(0);
    for (std::size_t i = 0; i < HAND_JOINTS; ++i)
    {
        const HandJoint& expected = first.hands[0].joints[i];
        EXPECT_LT((hand.joints[i].position - expected.position).norm(), 1e-9)
            << jointName(static_cast<int>(i));
        EXPECT_LT(hand.joints[i].orientation.angularDistance(expected.orientation), 1e-7);
        EXPECT_EQ(hand.joints[i].positionValid, expected.positionValid);
        EXPECT_NEAR(hand.joints[i].radius_m, expected.radius_m, 1e-12);
    }
    EXPECT_EQ(played.status(), "hands.csv: 2 recorded frames");
}

TEST(RecordedHandSource, InterpolatesAndDependsOnTimeAlone)
{
    RecordedHandSource played = source(recording({frameWith(0.0, Eigen::Vector3d(0.0, 0, 0)),
                                                  frameWith(0.1, Eigen::Vector3d(0.02, 0, 0)),
                                                  frameWith(0.2, Eigen::Vector3d(0.02, 0.04, 0))}));
    HandFrame frame;
    HandFrame again;
    ASSERT_TRUE(played.frameAt(0.05, frame));
    EXPECT_LT((indexTip(frame) - Eigen::Vector3d(0.01, 0, 0)).norm(), 1e-9);
    ASSERT_TRUE(played.frameAt(0.175, frame));
    EXPECT_LT((indexTip(frame) - Eigen::Vector3d(0.02, 0.03, 0)).norm(), 1e-9);
    ASSERT_TRUE(played.frameAt(0.05, again)); // going back gives the same
    EXPECT_LT((indexTip(again) - Eigen::Vector3d(0.01, 0, 0)).norm(), 1e-9);
    EXPECT_FALSE(played.frameAt(0.21, frame));
    EXPECT_TRUE(frame.hands.empty());
    EXPECT_EQ(frame.time_s, 0.21);
}

TEST(RecordedHandSource, LoopsAndLeavesLongGapsEmpty)
{
    const std::string text = recording({frameWith(0.0, Eigen::Vector3d(0, 0, 0)),
                                        frameWith(1.0, Eigen::Vector3d(1, 0, 0)),
                                        frameWith(1.1, Eigen::Vector3d(0, 0, 0))});
    RecordedHandSource once = source(text);
    RecordedHandSource looped = source(text, true);
    HandFrame frame;
    EXPECT_FALSE(once.frameAt(0.5, frame)); // lost for a second: not invented
    EXPECT_FALSE(once.frameAt(2.15, frame));
    ASSERT_TRUE(looped.frameAt(2.15, frame)); // 1.05 of the recording
    EXPECT_LT((indexTip(frame) - Eigen::Vector3d(0.5, 0, 0)).norm(), 1e-6);
}

TEST(RecordedHandSource, AJointLostInOneFrameIsNotInterpolated)
{
    HandFrame lost = frameWith(0.1, Eigen::Vector3d::Zero());
    lost.hands[0].joints[INDEX_TIP].positionValid = false;
    RecordedHandSource played = source(recording({frameWith(0.0, Eigen::Vector3d::Zero()), lost}));
    HandFrame frame;
    ASSERT_TRUE(played.frameAt(0.05, frame));
    EXPECT_FALSE(frame.hands[0].joints[INDEX_TIP].positionValid);
    EXPECT_TRUE(frame.hands[0].joints[MIDDLE_TIP].positionValid);
}

TEST(RecordedHandSource, ErrorsNameTheLine)
{
    EXPECT_EQ(
        sourceError(""),
        "hands.csv: no hand joints in it; a line is time_s,hand,joint,x,y,z,qx,qy,qz,qw,radius_m,"
        "position_valid,orientation_valid");
    EXPECT_EQ(sourceError("0,1,index_tip,0,0\n"),
              "hands.csv, line 1: 5 columns; a joint has 13: "
              "time_s,hand,joint,x,y,z,qx,qy,qz,qw,radius_m,"
              "position_valid,orientation_valid");
    EXPECT_EQ(sourceError("0,1,elbow,0,0,0,0,0,0,1,0.01,1,1\n"),
              "hands.csv, line 1: joint \"elbow\" is not known; index_tip is one");
    EXPECT_EQ(sourceError("0,1,palm,0,zero,0,0,0,0,1,0.01,1,1\n"),
              "hands.csv, line 1: \"zero\" in column 5 is not a finite number");
    EXPECT_EQ(sourceError("0,1,palm,0,0,0,0,0,0,2,0.01,1,1\n"),
              "hands.csv, line 1: the quaternion's length is not 1");
    EXPECT_EQ(sourceError("0,1.5,palm,0,0,0,0,0,0,1,0.01,1,1\n"),
              "hands.csv, line 1: hand \"1.5\" is not a whole number; 0 is the left one, 1 the "
              "right one");
    EXPECT_EQ(sourceError("1,1,palm,0,0,0,0,0,0,1,0.01,1,1\n0.5,1,wrist,0,0,0,0,0,0,1,0.01,1,1\n"),
              "hands.csv, line 2: time 0.5 is before the line above it");
    try
    {
        RecordedHandSource missing("/nowhere/hands.csv");
        FAIL();
    }
    catch (const base::InputError& error)
    {
        EXPECT_STREQ(error.what(),
                     "hand recording \"/nowhere/hands.csv\" can't be read: No such file or "
                     "directory");
    }
}

TEST(RecordedHandSource, AsksForNoMoreMemoryThanAHandIsWorth)
{
    const auto joint = [](double time_s, int hand) {
        return std::to_string(time_s) + "," + std::to_string(hand) +
               ",palm,0,0,0,0,0,0,1,0.01,1,1\n";
    };
    std::string hands;
    for (int hand = 0; hand < 9; ++hand)
        hands += joint(0.0, hand);
    EXPECT_EQ(sourceError(hands),
              "hands.csv, line 9: more than 8 hands at one time, which are the most possible");
    std::string frames;
    for (int frame = 0; frame <= 200000; ++frame)
        frames += joint(frame, 1);
    EXPECT_EQ(sourceError(frames),
              "hands.csv, line 200001: more than 200000 frames, which are the most possible");
    frames.clear();
    for (int frame = 0; frame < 66667; ++frame)
        for (int hand = 0; hand < 3; ++hand)
            frames += joint(frame, hand);
    EXPECT_EQ(sourceError(frames),
              "hands.csv, line 200001: more than 200000 hands in all frames together, which are "
              "the most possible");
}

TEST(RecordedHandSource, IsARegularFileOf64MiBAtMost)
{
    const std::string path = testing::TempDir() + "midair-hands-" + std::to_string(::getpid());
    std::ofstream(path) << "";
    std::filesystem::resize_file(path, (std::uintmax_t(64) << 20) + 1);
    const std::pair<std::string, std::string> wrong[] = {
        {path, "has 67108865 bytes, should have at most 64 MiB"},
        {"/dev/zero", "is a device or a pipe, should be a regular file"}};
    for (const auto& [name, what] : wrong)
        try
        {
            RecordedHandSource hands(name);
            ADD_FAILURE() << name;
        }
        catch (const base::InputError& error)
        {
            EXPECT_EQ(error.what(), "hand recording \"" + name + "\" " + what);
        }
    std::filesystem::remove(path);
}

TEST(RecordedHandSource, ImpossibleValuesAreNamed)
{
    EXPECT_EQ(sourceError("1e300,1,palm,0,0,0,0,0,0,1,0.01,1,1\n"),
              "hands.csv, line 1: time 1e300 is over 1e9 s");
    EXPECT_EQ(sourceError("0,1,palm,0,1e308,0,0,0,0,1,0.01,1,1\n"),
              "hands.csv, line 1: the joint is farther than 1e6 m from the origin");
    EXPECT_EQ(sourceError("0,1,palm,0,0,0,0,0,0,1,1e308,1,1\n"),
              "hands.csv, line 1: radius 1e308 is over 1000 m");
}

TEST(RecordedHandSource, LoopsOverTheShortestOfTimes)
{
    RecordedHandSource played = source("0,1,palm,0,0,0,0,0,0,1,0.01,1,1\n"
                                       "1e-320,1,palm,1,0,0,0,0,0,1,0.01,1,1\n",
                                       true);
    HandFrame frame;
    for (const double time_s : {0.0, 1.0, 1e9, -1.0})
    {
        ASSERT_TRUE(played.frameAt(time_s, frame)) << time_s;
        EXPECT_TRUE(frame.hands[0].joints[PALM].position.allFinite());
    }
}

TEST(RecordedHandSource, IsWrittenWithADecimalPointInEveryLocale)
{
    struct Comma : std::numpunct<char>
    {
        char do_decimal_point() const override { return ','; }
    };
    const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
    const std::string text = recording({frameWith(0.25, {0.5, 0, 0})});
    std::locale::global(before);
    EXPECT_EQ(source(text).frames().at(0).time_s, 0.25);
}

TEST(InjectedHandSource, GivesTheLastFrameUntilItIsStale)
{
    InjectedHandSource injected(0.2);
    HandFrame frame;
    EXPECT_FALSE(injected.frameAt(0.0, frame));
    injected.set(frameWith(1.0, Eigen::Vector3d(0.1, 0, 0)));
    ASSERT_TRUE(injected.frameAt(1.1, frame));
    EXPECT_LT((indexTip(frame) - Eigen::Vector3d(0.1, 0, 0)).norm(), 1e-15);
    EXPECT_FALSE(injected.frameAt(1.3, frame));
    EXPECT_TRUE(frame.hands.empty());
    injected.set(frameWith(1.3, Eigen::Vector3d::Zero()));
    injected.clear();
    EXPECT_FALSE(injected.frameAt(1.3, frame));
    EXPECT_EQ(injected.status(), "hands set by the application, 2 frames so far");
}

} // namespace

} // namespace midair::bridge
