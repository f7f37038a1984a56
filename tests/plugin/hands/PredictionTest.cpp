// Hands of a scene that are predicted to the moment when their sound arrives.
#include "tests/Eventually.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/HandSource>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// A right hand that goes along x at 0.5 m/s by the time that it is asked for.
class MovingHands : public HandSource
{
public:
    bool getHands(double time, std::vector<Hand>& hands) override
    {
        tip = osg::Vec3d(0.5 * (time - age), 0.0, 0.3);
        hands = {openHand(1, tip, osg::Quat())};
        hands[0].age = saysAge ? age : wrongAge;
        return true;
    }
    std::string getStatus() const override { return "moving"; }

    osg::Vec3d tip;   ///< as it was seen last
    double age = 0.0; ///< s
    bool saysAge = true;
    double wrongAge = 0.0; ///< what it says else

protected:
    ~MovingHands() override = default;
};

/// One that can predict them by itself.
class ProphetHands : public MovingHands
{
public:
    bool setHorizon(double ahead) override
    {
        asked.push_back(ahead);
        return true;
    }

    std::vector<double> asked;

protected:
    ~ProphetHands() override = default;
};

/// The tip of the index finger that the scene plays for, in the array's frame.
double playedTip(const BoxScene& box)
{
    const auto& hands = SceneAccess::engine(*box.scene).hands().frame().hands;
    return hands.empty() ? std::numeric_limits<double>::quiet_NaN()
                         : hands[0].joints[midair::bridge::INDEX_TIP].position.x();
}

struct PredictedScene : BoxScene
{
    osg::ref_ptr<MovingHands> hands;
    HeadlessViewer viewer{scene};
    double time_s = 0.0;

    explicit PredictedScene(MovingHands* source = new MovingHands) : hands(source)
    {
        scene->setHandSource(hands);
    }

    /// Frames of a clock of their own, 100 a second.
    void frames(int count)
    {
        for (int i = 0; i < count; ++i)
        {
            viewer.viewer.advance(time_s += 0.01);
            viewer.viewer.eventTraversal();
            viewer.viewer.updateTraversal();
        }
    }

    double ahead_m() const { return playedTip(*this) - hands->tip.x(); }

    std::vector<std::string> told() const
    {
        std::vector<std::string> texts;
        for (const HapticMessage& message : scene->getStatistics().told)
            if (message.code == "hands.prediction") texts.push_back(message.text);
        return texts;
    }
};

} // namespace

TEST(HandsPrediction, ByDefaultHandsAreWhereTheyWereSeen)
{
    PredictedScene box;
    box.scene->setTrackerDelay(0.1);
    box.frames(30);
    EXPECT_NEAR(box.ahead_m(), 0.0, 1e-12);
    EXPECT_EQ(box.scene->getStatistics().predicted_ms, 0.0);
}

TEST(HandsPrediction, HandsArePredictedByWhatTheKitMeasuresAndTheTrackersDelay)
{
    PredictedScene box;
    box.scene->setPrediction(HapticSettings::KALMAN);
    box.scene->setTrackerDelay(0.04);
    box.hands->age = 0.005;
    // Fields come, and with them the time that they take.
    ASSERT_TRUE(
        box.viewer.framesUntil([&] { return box.scene->getStatistics().latencyP50_ms > 0; }));
    box.time_s = 1000.0;
    box.frames(60);
    const HapticStatistics now = box.scene->getStatistics();
    // The way through the air is 0.9 ms more.
    EXPECT_GT(now.predicted_ms, 45.9);
    EXPECT_NEAR(now.predicted_ms, 45.9 + now.latencyP50_ms, 5.0 + 0.5 * now.latencyP50_ms);
    EXPECT_NEAR(box.ahead_m(), 0.5 * 1e-3 * now.predicted_ms, 1e-4);
    box.scene->setPrediction(HapticSettings::OFF);
    box.frames(2);
    EXPECT_NEAR(box.ahead_m(), 0.0, 1e-12);
    EXPECT_EQ(box.scene->getStatistics().predicted_ms, 0.0);
    EXPECT_TRUE(box.told().empty());
}

TEST(HandsPrediction, AnAgeThatIsNoneIsToldOnceAndHandsStay)
{
    PredictedScene box;
    box.scene->setPrediction(HapticSettings::ALPHA_BETA);
    box.hands->saysAge = false;
    box.hands->wrongAge = -0.01;
    box.frames(30);
    EXPECT_NEAR(box.ahead_m(), 0.0, 1e-12);
    ASSERT_EQ(box.told().size(), 1u);
    EXPECT_NE(box.told()[0].find("from a measurement that is -0.01 s old"), std::string::npos);
}

TEST(HandsPrediction, ASourceThatPredictsIsAskedForThatTime)
{
    const osg::ref_ptr<ProphetHands> prophet = new ProphetHands;
    PredictedScene box(prophet);
    box.frames(3);
    EXPECT_TRUE(prophet->asked.empty());
    box.scene->setPrediction(HapticSettings::TRACKER);
    box.scene->setTrackerDelay(0.02);
    box.frames(3);
    ASSERT_EQ(prophet->asked.size(), 3u);
    EXPECT_GE(prophet->asked[0], 0.0209 - 1e-9);
    EXPECT_LT(prophet->asked[0], 1.0);
    EXPECT_NEAR(box.ahead_m(), 0.0, 1e-12); // the source has done it
    EXPECT_GT(box.scene->getStatistics().predicted_ms, 20.0);
    box.scene->setPrediction(HapticSettings::KALMAN);
    box.frames(3);
    ASSERT_EQ(prophet->asked.size(), 4u);
    EXPECT_EQ(prophet->asked[3], 0.0);
    EXPECT_TRUE(box.told().empty());
    box.scene->setPrediction(HapticSettings::TRACKER);
    box.frames(1);
    box.scene->setHandSource(new MovingHands); // the one before is left as it was found
    box.frames(1);
    EXPECT_EQ(prophet->asked.back(), 0.0);
}

TEST(HandsPrediction, ASourceThatCantPredictIsToldOnceAndHandsStay)
{
    PredictedScene box;
    box.scene->setPrediction(HapticSettings::TRACKER);
    box.frames(10);
    EXPECT_NEAR(box.ahead_m(), 0.0, 1e-12);
    EXPECT_EQ(box.told(),
              std::vector<std::string>{
                  "prediction is left to the tracker, but the hand source doesn't predict hands: "
                  "they are felt late. prediction=kalman predicts them"});
}

TEST(HandsPrediction, InjectedHandsGrowOld)
{
    const osg::ref_ptr<InjectedHands> hands = new InjectedHands;
    Hand hand = openHand(1, osg::Vec3d(), osg::Quat());
    hand.age = 0.5;
    hands->setHands({hand});
    std::vector<Hand> got;
    EXPECT_TRUE(
        eventually([&] { return hands->getHands(0.0, got) && got.at(0).age >= 0.51 - 1e-6; }));
    EXPECT_LT(got[0].age, 10.0);
}

TEST(HandsPrediction, SettingsAreCheckedAsOthersAre)
{
    HapticSettings settings;
    std::string error;
    EXPECT_TRUE(settings.set("prediction", "alpha-beta", error));
    EXPECT_EQ(settings.prediction, HapticSettings::ALPHA_BETA);
    EXPECT_TRUE(settings.set("trackerDelay", "45 ms", error));
    EXPECT_DOUBLE_EQ(settings.trackerDelay, 0.045);
    EXPECT_FALSE(settings.set("prediction", "kalmann", error));
    EXPECT_NE(error.find("off, tracker, alpha-beta, kalman, one-euro"), std::string::npos) << error;
    for (const double wrong : {-0.01, 0.3, std::numeric_limits<double>::quiet_NaN()})
    {
        settings.trackerDelay = wrong;
        EXPECT_EQ(settings.repair().size(), 1u) << wrong;
        EXPECT_EQ(settings.trackerDelay, 0.0);
    }
    settings.prediction = static_cast<HapticSettings::Prediction>(99); // of a binary file
    EXPECT_EQ(settings.repair().size(), 1u);
    EXPECT_EQ(settings.prediction, HapticSettings::OFF);
    EXPECT_FALSE(settings.isSilenced);
}
