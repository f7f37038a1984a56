#include "engine-bridge/hands/prediction/HandPredictor.h"

#include "tests/engine-bridge/hands/prediction/Crossing.h"

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A right hand whose index finger's tip is at \a tip, as it was seen \a age_s ago.
Hand handAt(const Vector3d& tip, int id = 1, double age_s = 0.0)
{
    Hand hand = openHandWithIndexTipAt(id, tip, Eigen::Quaterniond::Identity());
    hand.age_s = age_s;
    return hand;
}

/// 0.5 m/s along x.
Vector3d movingTip(double time_s)
{
    return {0.5 * time_s, 0.0, 0.0};
}

const Vector3d& tipOf(const Hand& hand)
{
    return hand.joints[INDEX_TIP].position;
}

bool isSame(const Hand& a, const Hand& b)
{
    for (std::size_t i = 0; i < HAND_JOINTS; ++i)
        if (a.joints[i].position != b.joints[i].position) return false;
    return true;
}

/// A predictor that is given a hand at 0.5 m/s, and what becomes of it.
struct Moving
{
    HandPredictor predictor;
    double time_s = 0.0;
    double horizon_s = 0.05;
    std::vector<std::string> said;

    explicit Moving(PredictionMethod method = PredictionMethod::KALMAN)
    {
        predictor.setMethod(method);
    }

    std::vector<Hand> give(std::vector<Hand> hands)
    {
        HandFrame frame;
        frame.time_s = time_s;
        frame.hands = std::move(hands);
        predictor.predict(frame, horizon_s);
        for (const std::string& message : predictor.takeMessages())
            said.push_back(message);
        return frame.hands;
    }

    /// Steps on for \a frames frames. Returns the last.
    Hand go(int frames = 30)
    {
        Hand last;
        for (int i = 0; i < frames; ++i)
        {
            time_s += 1.0 / kTracker_Hz;
            last = give({handAt(movingTip(time_s))})[0];
        }
        return last;
    }

    /// How far the tip of \a hand is ahead of where it is now, m.
    double ahead_m(const Hand& hand) const { return tipOf(hand).x() - movingTip(time_s).x(); }
};

/// The errors, per hand, of two fingertips of a hand that reaches, turns and bends.
PredictionErrors tipErrors(PredictionMethod method, double noise_m, bool moves)
{
    const Reaching reaching(60.0);
    std::mt19937_64 random(6);
    HandPredictor predictor;
    predictor.setMethod(method);
    std::vector<double> errors;
    std::vector<double> sigmas;
    for (int i = 0; i < 59 * static_cast<int>(kTracker_Hz); ++i)
    {
        HandFrame frame;
        frame.time_s = i / kTracker_Hz;
        frame.hands.push_back(reachingHand(reaching, moves ? frame.time_s : 0.0));
        addNoise(random, noise_m, frame.hands[0]);
        predictor.predict(frame, 0.05);
        const Hand truth = reachingHand(reaching, moves ? frame.time_s + 0.05 : 0.0);
        for (const std::size_t joint : {INDEX_TIP, LITTLE_TIP})
        {
            const HandJoint& now = frame.hands[0].joints[joint];
            errors.push_back((now.position - truth.joints[joint].position).norm());
            sigmas.push_back(now.sigma_m);
        }
    }
    return summed(std::move(errors), sigmas);
}

/// The largest relative difference of a bone's length from that in \a measured.
double worstBone(const Hand& hand, const Hand& measured)
{
    const auto capsules = handCapsules({0.0, {hand}, {}});
    const auto before = handCapsules({0.0, {measured}, {}});
    double worst = 0.0;
    for (std::size_t i = 0; i < capsules.size(); ++i)
    {
        const double length = (before[i].shape.a - before[i].shape.b).norm();
        const double now = (capsules[i].shape.a - capsules[i].shape.b).norm();
        worst = std::max(worst, std::abs(now / length - 1.0));
    }
    return worst;
}

} // namespace

TEST(HandPredictor, OffLeavesHandsAsTheyAre)
{
    Moving moving(PredictionMethod::OFF);
    const Hand hand = moving.go();
    EXPECT_TRUE(isSame(hand, handAt(movingTip(moving.time_s))));
    EXPECT_EQ(hand.joints[INDEX_TIP].sigma_m, 0.0);
    EXPECT_EQ(moving.predictor.ahead_s(), 0.0);
}

TEST(HandPredictor, AHandThatMovesSteadilyIsWhereItWillBe)
{
    for (const auto method :
         {PredictionMethod::ALPHA_BETA, PredictionMethod::KALMAN, PredictionMethod::ONE_EURO})
        for (const double horizon_s : {0.0, 0.02, 0.07, 0.2})
        {
            Moving moving(method);
            moving.horizon_s = horizon_s;
            EXPECT_NEAR(moving.ahead_m(moving.go(90)), 0.5 * horizon_s, 1e-5);
            EXPECT_NEAR(moving.predictor.ahead_s(), horizon_s, 1e-9);
            EXPECT_TRUE(moving.said.empty());
        }
}

TEST(HandPredictor, AHandsAgeIsMadeUpFor)
{
    Moving moving;
    Hand hand;
    for (int i = 0; i < 60; ++i)
    {
        moving.time_s += 1.0 / kTracker_Hz;
        const double age_s = i % 3 == 0 ? 0.002 : 0.009; // of a tracker with a clock of its own
        hand = moving.give({handAt(movingTip(moving.time_s - age_s), 1, age_s)})[0];
    }
    EXPECT_NEAR(moving.ahead_m(hand), 0.5 * 0.05, 1e-5);
}

TEST(HandPredictor, BetweenTheTrackersFramesAHandGoesOn)
{
    Moving moving;
    moving.go();
    const Hand seen = handAt(movingTip(moving.time_s));
    for (int i = 0; i < 3; ++i) // frames at 250 Hz
    {
        moving.time_s += 0.004;
        EXPECT_NEAR(moving.ahead_m(moving.give({seen})[0]), 0.5 * 0.05, 1e-5);
    }
    moving.time_s += 0.05; // what hasn't moved for so long stands
    EXPECT_TRUE(isSame(moving.give({seen})[0], seen));
}

TEST(HandPredictor, BonesKeepTheirLengths)
{
    const Reaching reaching(5.0);
    for (const double noise_m : {0.0, kTrackerNoise_m})
    {
        std::mt19937_64 random(7);
        HandPredictor predictor;
        predictor.setMethod(PredictionMethod::KALMAN);
        double moved_m = 0.0;
        for (int i = 0; i < 400; ++i)
        {
            HandFrame frame;
            frame.time_s = i / kTracker_Hz;
            Hand seen = reachingHand(reaching, frame.time_s);
            addNoise(random, noise_m, seen);
            frame.hands.push_back(seen);
            predictor.predict(frame, 0.07);
            EXPECT_LT(worstBone(frame.hands[0], seen), 1e-9);
            moved_m = std::max(moved_m, (tipOf(frame.hands[0]) - tipOf(seen)).norm());
        }
        EXPECT_GT(moved_m, 0.05);
    }
}

TEST(HandPredictor, FingertipsOfAHandThatReachesTurnsAndBendsAreNearerToTheTruth)
{
    const PredictionErrors off = tipErrors(PredictionMethod::OFF, kTrackerNoise_m, true);
    const PredictionErrors kalman = tipErrors(PredictionMethod::KALMAN, kTrackerNoise_m, true);
    EXPECT_LT(kalman.rms_m, 0.3 * off.rms_m);
    EXPECT_LT(kalman.most_m, 0.3 * off.most_m);
    // In three coordinates.
    EXPECT_LT(kalman.rms_m, std::sqrt(3.0) * kalman.sigma_m);
    EXPECT_GT(kalman.rms_m, 0.2 * std::sqrt(3.0) * kalman.sigma_m);
}

TEST(HandPredictor, AHandAtRestHasAtMostAThirdMoreNoiseThanTheTracker)
{
    const double most_m = 1.3 * kTrackerNoise_m;
    for (const auto method :
         {PredictionMethod::ALPHA_BETA, PredictionMethod::KALMAN, PredictionMethod::ONE_EURO})
    {
        EXPECT_LT(tipErrors(method, kTrackerNoise_m, false).rms_m, std::sqrt(3.0) * most_m);
        EXPECT_LT(trackErrors(method, 0.05, false).rms_m, most_m);
    }
    // The price: a reach is predicted no worse than without that.
    EXPECT_LT(trackErrors(PredictionMethod::KALMAN, 0.05, true).rms_m, 1.1 * 4.8e-3);
}

TEST(HandPredictor, AFewJointsMoveAsOne)
{
    Moving moving;
    Hand hand;
    for (int i = 0; i < 30; ++i)
    {
        moving.time_s += 1.0 / kTracker_Hz;
        Hand finger = handAt(movingTip(moving.time_s));
        for (std::size_t joint = 0; joint < HAND_JOINTS; ++joint)
            finger.joints[joint].positionValid = joint == INDEX_DISTAL || joint == INDEX_TIP;
        hand = moving.give({finger})[0];
    }
    EXPECT_NEAR(moving.ahead_m(hand), 0.5 * 0.05, 1e-5);
    EXPECT_FALSE(hand.joints[PALM].positionValid);
}

TEST(HandPredictor, AFingerThatIsLostAndFoundDisturbsNothingElse)
{
    Moving moving;
    moving.go();
    moving.time_s += 1.0 / kTracker_Hz;
    Hand hand = handAt(movingTip(moving.time_s));
    hand.joints[LITTLE_TIP].positionValid = false;
    EXPECT_NEAR(moving.ahead_m(moving.give({hand})[0]), 0.5 * 0.05, 1e-5);
    EXPECT_NEAR(moving.ahead_m(moving.go(1)), 0.5 * 0.05, 1e-5);
}

TEST(HandPredictor, AcrossAGapNothingIsPredicted)
{
    Moving moving;
    moving.go();
    moving.time_s += 0.051;
    const Hand seen = handAt(movingTip(moving.time_s));
    const Hand after = moving.give({seen})[0];
    EXPECT_TRUE(isSame(after, seen));
    EXPECT_GT(after.joints[INDEX_TIP].sigma_m, 0.04); // it may be anywhere by now
    EXPECT_NEAR(moving.ahead_m(moving.go(40)), 0.5 * 0.05, 1e-5);
    moving.time_s = 0.01; // a recording begins again
    const Hand again = handAt(movingTip(moving.time_s));
    EXPECT_TRUE(isSame(moving.give({again})[0], again));
    EXPECT_TRUE(moving.said.empty());
}

TEST(HandPredictor, AJointThatIsNoNumberStopsThatHandAloneAndIsToldOnce)
{
    Moving moving;
    std::vector<Hand> last;
    for (int i = 0; i < 60; ++i)
    {
        moving.time_s += 1.0 / kTracker_Hz;
        Hand wrong = handAt(movingTip(moving.time_s), 0);
        if (i >= 30) wrong.joints[RING_TIP].position.y() = kNaN;
        last = moving.give({wrong, handAt(movingTip(moving.time_s), 1)});
    }
    EXPECT_EQ(moving.ahead_m(last[0]), 0.0);
    EXPECT_NEAR(moving.ahead_m(last[1]), 0.5 * 0.05, 1e-5);
    EXPECT_EQ(
        moving.said,
        std::vector<std::string>{"the ring tip of the left hand is marked as tracked, but its "
                                 "position is not finite: the hand is not predicted until it is"});
    EXPECT_EQ(handCapsules({0.0, {last[0]}, {}}).size(), static_cast<std::size_t>(kHandBones - 1));
    for (const HandJoint& joint : last[1].joints)
        EXPECT_TRUE(joint.position.allFinite() && std::isfinite(joint.sigma_m));
    EXPECT_NEAR(moving.ahead_m(moving.go(40)), 0.5 * 0.05, 1e-5); // and goes on with the other
}

TEST(HandPredictor, AHandThatJumpsIsBegunAnewAndToldOnce)
{
    Moving moving;
    moving.go();
    for (int i = 0; i < 2; ++i)
    {
        moving.time_s += 1.0 / kTracker_Hz;
        const Hand far = handAt(movingTip(moving.time_s) + Vector3d(0.0, i == 0 ? 1.0 : 0.0, 0.0));
        EXPECT_TRUE(isSame(moving.give({far})[0], far)) << i;
    }
    EXPECT_EQ(moving.said,
              std::vector<std::string>{"the right hand jumped by 1.00 m between two measurements: "
                                       "its prediction starts again from there"});
    EXPECT_NEAR(moving.ahead_m(moving.go(40)), 0.5 * 0.05, 1e-5);
}

TEST(HandPredictor, AHorizonThatIsNoneIsToldOnceAndLeavesHandsWhereTheyWereSeen)
{
    for (const double horizon_s : {-0.01, kNaN, std::numeric_limits<double>::infinity()})
    {
        Moving moving;
        moving.go();
        moving.horizon_s = horizon_s;
        EXPECT_EQ(moving.ahead_m(moving.go()), 0.0);
        ASSERT_EQ(moving.said.size(), 1u);
        EXPECT_EQ(moving.said[0].find("the right hand can't be predicted by "), 0u);
    }
    Moving moving;
    std::vector<Hand> last;
    for (int i = 0; i < 30; ++i)
    {
        moving.time_s += 1.0 / kTracker_Hz;
        const Vector3d tip = movingTip(moving.time_s);
        last = moving.give({handAt(tip, 0, -0.02), handAt(tip, 1), handAt(tip, 7, kNaN)});
    }
    EXPECT_EQ(moving.ahead_m(last[0]), 0.0);
    EXPECT_NEAR(moving.ahead_m(last[1]), 0.5 * 0.05, 1e-5);
    EXPECT_EQ(moving.ahead_m(last[2]), 0.0);
    ASSERT_EQ(moving.said.size(), 2u);
    EXPECT_EQ(moving.said[0],
              "the left hand can't be predicted by 0.05 s from a measurement that is -0.02 s old; "
              "both should be 0 or more: it stays where it was seen");
    EXPECT_EQ(moving.said[1].find("hand 7 can't be predicted by 0.05 s from"), 0u);
}

TEST(HandPredictor, AHorizonThatIsTooFarIsCutAndToldOnce)
{
    Moving moving;
    moving.horizon_s = 0.4;
    EXPECT_NEAR(moving.ahead_m(moving.go(60)), 0.5 * HandPredictor::kFarthest_s, 1e-4);
    EXPECT_EQ(moving.said,
              std::vector<std::string>{"the right hand needs a prediction of 400 ms, more than the "
                                       "limit of 250 ms: it is felt late"});
}

TEST(HandPredictor, OfTwoHandsWithOneNumberTheFirstIsPredicted)
{
    Moving moving;
    std::vector<Hand> last;
    for (int i = 0; i < 30; ++i)
    {
        moving.time_s += 1.0 / kTracker_Hz;
        const Vector3d tip = movingTip(moving.time_s);
        last = moving.give({handAt(tip), handAt(tip + Vector3d(0.0, 0.2, 0.0))});
    }
    EXPECT_NEAR(moving.ahead_m(last[0]), 0.5 * 0.05, 1e-5);
    EXPECT_EQ(moving.ahead_m(last[1]), 0.0);
    EXPECT_EQ(moving.said,
              std::vector<std::string>{
                  "there are two of the right hand at one time: only the first is predicted"});
}

TEST(HandPredictor, WhatTheTrackerPredictsGetsItsErrorOnly)
{
    Moving moving(PredictionMethod::TRACKER);
    const Hand hand = moving.go();
    EXPECT_TRUE(isSame(hand, handAt(movingTip(moving.time_s))));
    EXPECT_NEAR(hand.joints[INDEX_TIP].sigma_m, std::hypot(1e-3, 0.5 * 5.0 * 0.05 * 0.05), 1e-9);
    EXPECT_EQ(handCapsules({0.0, {hand}, {}})[0].sigma_m, hand.joints[INDEX_TIP].sigma_m);
}

TEST(HandPredictor, AFingerThatCrossesAPlateIsPressedOnTheSideThatMeetsIt)
{
    const CrossedSkin late = crossPlate(PredictionMethod::OFF, 0.07, 3);
    EXPECT_GT(late.far_Pa2, late.near_Pa2);
    for (const auto method : {PredictionMethod::ALPHA_BETA, PredictionMethod::KALMAN})
    {
        const CrossedSkin predicted = crossPlate(method, 0.07, 3);
        EXPECT_LT(predicted.far_Pa2, 0.15 * predicted.near_Pa2);
        EXPECT_GT(predicted.near_Pa2, 5.0 * late.near_Pa2);
    }
}

} // namespace midair::bridge
