#include "engine-bridge/hands/tracking/HandTracker.h"

#include "engine-bridge/hands/opening/HandOpening.h"
#include "haptics/base/InputError.h"

#include <stdexcept>

#include <gtest/gtest.h>

using namespace midair::bridge;
using midair::base::Message;
using midair::base::MessageCode;

namespace
{

/// One hand with its index finger at a place, unless it is told to fail.
class OneHand : public HandSource
{
public:
    bool frameAt(double, HandFrame& frame) override
    {
        if (fails) throw std::runtime_error("no glove");
        frame.hands = {openHandWithIndexTipAt(1, tip, Eigen::Quaterniond::Identity())};
        return true;
    }
    std::string status() const override { return "one hand"; }

    Eigen::Vector3d tip{0.1, 0.2, 0.3};
    bool fails = false;
};

Eigen::Vector3d tipOf(const HandTracker& tracker)
{
    return tracker.frame().hands.front().joints[INDEX_TIP].position;
}

HandTracker::Opener opener()
{
    return [](const std::string& uri) { return openHands(uri); };
}

} // namespace

TEST(HandTracker, FindsHandsInTheArraysFrame)
{
    HandTracker tracker(opener());
    tracker.setSource(std::make_shared<OneHand>());
    Eigen::Isometry3d toArray = Eigen::Isometry3d::Identity();
    toArray.translation() = Eigen::Vector3d(1.0, 0.0, 0.0);
    tracker.locate(5.0, toArray);
    ASSERT_EQ(tracker.frame().hands.size(), 1U);
    EXPECT_EQ(tracker.frame().time_s, 5.0);
    EXPECT_TRUE(tipOf(tracker).isApprox(Eigen::Vector3d(1.1, 0.2, 0.3), 1e-12));
}

TEST(HandTracker, ASourceThatThrowsIsToldAndHasNoHands)
{
    HandTracker tracker(opener());
    const auto source = std::make_shared<OneHand>();
    tracker.setSource(source);
    tracker.locate(0.0, Eigen::Isometry3d::Identity());
    EXPECT_TRUE(tracker.troubles().empty());
    source->fails = true;
    tracker.locate(1.0, Eigen::Isometry3d::Identity());
    EXPECT_TRUE(tracker.frame().hands.empty());
    const std::vector<Message> told = tracker.troubles();
    ASSERT_EQ(told.size(), 1U);
    EXPECT_EQ(told[0].code, MessageCode::HANDS_THREW);
    EXPECT_EQ(told[0].text,
              "the application's hand source has thrown \"no glove\": there are no hands while it "
              "does");
    source->fails = false;
    tracker.locate(2.0, Eigen::Isometry3d::Identity());
    EXPECT_EQ(tracker.frame().hands.size(), 1U);
    EXPECT_TRUE(tracker.troubles().empty());
}

TEST(HandTracker, TheProgramsSourceComesBeforeTheNamedOne)
{
    std::string error;
    static const bool isRegistered = registerHands(
        "tracker-test", [](const std::string&) { return std::make_shared<OneHand>(); }, error);
    ASSERT_TRUE(isRegistered) << error;
    HandTracker tracker(opener());
    EXPECT_EQ(tracker.setNamed("tracker-test:"), "");
    tracker.locate(0.0, Eigen::Isometry3d::Identity());
    EXPECT_EQ(tracker.frame().hands.size(), 1U);
    const auto own = std::make_shared<OneHand>();
    own->tip = Eigen::Vector3d(-0.1, 0.0, 0.2);
    tracker.setSource(own);
    tracker.locate(0.1, Eigen::Isometry3d::Identity());
    EXPECT_TRUE(tipOf(tracker).isApprox(own->tip, 1e-12));
    tracker.setSource(nullptr);
    tracker.setNamed("");
    tracker.locate(0.2, Eigen::Isometry3d::Identity());
    EXPECT_TRUE(tracker.frame().hands.empty());
}

TEST(HandTracker, WhatIsWrongWithANameIsSaidOnce)
{
    HandTracker tracker(opener());
    EXPECT_EQ(tracker.setNamed("glove:"), unknownHands("glove:"));
    EXPECT_FALSE(unknownHands("glove:").empty());
    EXPECT_EQ(tracker.setNamed("glove:"), "");
}
