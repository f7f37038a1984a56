#include "engine-bridge/heads/HeadTracker.h"

#include "engine-bridge/heads/HeadOpening.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;

/// A head that moves along x at 0.5 m/s and turns about z by 1 rad/s, or is what a test wants.
class MovingHead : public HeadSource
{
public:
    bool headAt(double time_s, Head& head) override
    {
        if (throws) throw 7;
        head.pose = Eigen::Translation3d(0.5 * time_s, 0.0, 0.4) *
                    Eigen::AngleAxisd(time_s, Vector3d::UnitZ());
        if (isNowhere) head.pose.translation().x() = std::nan("");
        head.age_s = age_s;
        head.isTracked = isTracked;
        return isTracked;
    }
    bool setHorizon(double ahead_s) override
    {
        horizon_s = ahead_s;
        return tellsLater;
    }
    std::string status() const override { return "moving"; }
    std::vector<std::string> takeMessages() override { return std::exchange(messages, {}); }

    bool isTracked = true;
    bool throws = false;
    bool isNowhere = false;
    bool tellsLater = false;
    double age_s = 0.0;
    double horizon_s = 0.0;
    std::vector<std::string> messages;
};

HeadTracker::Opener headOpener()
{
    return [](const std::string& text) { return openHead(text); };
}

bool tells(const std::vector<base::Message>& all, const std::string& text)
{
    return std::any_of(all.begin(),
                       all.end(),
                       [&](const base::Message& one)
                       { return one.text.find(text) != std::string::npos; });
}

/// A tracker of a moving head.
struct Followed
{
    Followed() { tracker.setSource(source); }
    void go(double to_s)
    {
        for (; time_s < to_s - 1e-9; time_s += 0.01)
            tracker.locate(time_s);
        tracker.locate(time_s);
    }

    std::shared_ptr<MovingHead> source = std::make_shared<MovingHead>();
    HeadTracker tracker{headOpener()};
    double time_s = 0.0;
};

} // namespace

TEST(HeadTracker, EarsAreBesideTheEyes)
{
    const Eigen::Isometry3d pose =
        Eigen::Translation3d(1, 2, 3) * Eigen::AngleAxisd(2.0, Vector3d(1, 2, 3).normalized());
    const Eigen::Matrix<double, 3, 2> ears = earsOf(pose);
    EXPECT_LT((ears.col(0) - pose * Vector3d(-0.08, 0, 0)).norm(), 1e-12);
    EXPECT_LT((ears.col(1) - pose * Vector3d(0.08, 0, 0)).norm(), 1e-12);
}

TEST(HeadTracker, ALostHeadKeepsItsLastPlaceAndSaysSo)
{
    Followed of;
    EXPECT_FALSE(of.tracker.lastPlace());
    of.source->isTracked = false;
    of.go(0.1);
    EXPECT_FALSE(of.tracker.lastPlace()) << "it was never seen";
    EXPECT_TRUE(of.tracker.troubles().empty());
    of.source->isTracked = true;
    of.go(0.2);
    ASSERT_TRUE(of.tracker.lastPlace());
    EXPECT_NEAR(of.tracker.lastPlace()->translation().x(), 0.1, 1e-9);
    EXPECT_TRUE(of.tracker.head().isTracked);
    of.source->isTracked = false;
    of.go(60.0);
    EXPECT_FALSE(of.tracker.head().isTracked);
    ASSERT_TRUE(of.tracker.lastPlace());
    EXPECT_NEAR(of.tracker.lastPlace()->translation().x(), 0.1, 1e-9);
    EXPECT_TRUE(tells(of.tracker.troubles(),
                      "the head is lost: its last position is used, also for the ear limit"));
    of.tracker.setSource(nullptr);
    EXPECT_FALSE(of.tracker.lastPlace()) << "of a source that is gone";
    EXPECT_TRUE(of.tracker.troubles().empty());
}

TEST(HeadTracker, WhatIsNowhereOrThrowsIsNotTracked)
{
    Followed of;
    of.go(0.1);
    of.source->isNowhere = true;
    of.go(0.2);
    EXPECT_FALSE(of.tracker.head().isTracked);
    EXPECT_TRUE(tells(of.tracker.troubles(), "should be within 1000 m"));
    EXPECT_NEAR(of.tracker.lastPlace()->translation().x(), 0.05, 1e-9);
    of.source->isNowhere = false;
    of.source->throws = true;
    of.go(0.3);
    EXPECT_FALSE(of.tracker.head().isTracked);
    EXPECT_TRUE(tells(of.tracker.troubles(), "the application's head source has thrown "));
    EXPECT_TRUE(tells(of.tracker.troubles(), ": there is no head while it does"));
    of.source->throws = false;
    of.source->messages = {"hello"};
    of.go(0.4);
    EXPECT_TRUE(of.tracker.head().isTracked);
    EXPECT_TRUE(tells(of.tracker.takeMessages(), "hello"));
    EXPECT_EQ(of.tracker.status(), "moving");
}

TEST(HeadTracker, IsPredictedAsHandsAre)
{
    for (const PredictionMethod method :
         {PredictionMethod::KALMAN, PredictionMethod::ALPHA_BETA, PredictionMethod::ONE_EURO})
    {
        Followed of;
        of.tracker.setPrediction(method, 0.02);
        of.tracker.setLatency(0.0291); // with the sound's 0.9 ms it is 50 ms
        of.go(1.0);
        const Eigen::Isometry3d& pose = of.tracker.head().pose;
        EXPECT_NEAR(pose.translation().x(), 0.5 * 1.05, 2e-3) << static_cast<int>(method);
        EXPECT_NEAR(Eigen::AngleAxisd(pose.linear()).angle(), 1.05, 0.01)
            << static_cast<int>(method);
        EXPECT_TRUE(pose.linear().isUnitary(1e-9));
        EXPECT_NEAR(of.tracker.lastPlace()->translation().x(), pose.translation().x(), 1e-12);
    }
    Followed late;
    late.go(1.0);
    EXPECT_NEAR(late.tracker.head().pose.translation().x(), 0.5, 1e-9) << "off";
}

TEST(HeadTracker, TheTrackerIsAskedForThatTime)
{
    Followed of;
    of.tracker.setPrediction(PredictionMethod::TRACKER, 0.02);
    of.go(0.1);
    EXPECT_TRUE(tells(of.tracker.troubles(), "doesn't predict the head"));
    Followed later;
    later.source->tellsLater = true;
    later.tracker.setPrediction(PredictionMethod::TRACKER, 0.02);
    later.go(0.1);
    EXPECT_NEAR(later.source->horizon_s, 0.0209, 1e-9);
    EXPECT_TRUE(later.tracker.troubles().empty());
    later.tracker.setPrediction(PredictionMethod::OFF, 0.02);
    later.go(0.2);
    EXPECT_EQ(later.source->horizon_s, 0.0);
}

TEST(HeadTracker, WhatIsWrongWithANameIsTold)
{
    HeadTracker tracker(headOpener());
    EXPECT_EQ(tracker.setNamed("fixed 0 0 0.5"), "");
    tracker.locate(0.0);
    EXPECT_TRUE(tracker.head().isTracked);
    EXPECT_NE(tracker.setNamed("fixd 0 0 0.5"), "");
    EXPECT_TRUE(tells(tracker.troubles(), "(did you mean fixed?)"));
    tracker.locate(0.1);
    EXPECT_FALSE(tracker.lastPlace());
    EXPECT_EQ(tracker.status(), "");
    EXPECT_EQ(tracker.setNamed(""), "");
    EXPECT_TRUE(tracker.troubles().empty());
}

} // namespace midair::bridge
