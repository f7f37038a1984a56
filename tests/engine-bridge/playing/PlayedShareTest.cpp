#include "engine-bridge/playing/ArrayOutput.h"

#include <random>

#include <gtest/gtest.h>

using namespace midair;

TEST(PlayedShare, OfADeviceThatPlaysNothingIsAFaultAndEndsWhenItPlays)
{
    bridge::PlayedShare share;
    device::DeviceReport report;
    for (int i = 0; i < 100; ++i, ++report.sent, ++report.played)
        EXPECT_FALSE(share.isFaulty(report));
    int after = 0;
    for (; after < 100 && !share.isFaulty(report); ++after)
        ++report.lost;
    EXPECT_GT(after, 5) << "a few losses are none";
    EXPECT_LT(after, 30);
    for (after = 0; after < 100 && share.isFaulty(report); ++after)
        ++report.played;
    EXPECT_LT(after, 30);
}

// What a simulated array of 16 boards loses with a chance of 0.01 a packet.
TEST(PlayedShare, OfANoisyLineIsNoFault)
{
    bridge::PlayedShare share;
    device::DeviceReport report;
    std::mt19937 random(1);
    for (int i = 0; i < 10000; ++i)
    {
        ++(std::bernoulli_distribution(0.71)(random) ? report.played : report.lost);
        ASSERT_FALSE(share.isFaulty(report)) << i;
    }
}

TEST(PlayedShare, FieldsThatANewerOneReplacedOrAMuteRefusedDoNotCount)
{
    bridge::PlayedShare share;
    device::DeviceReport report;
    report.played = 10;
    share.isFaulty(report);
    report.dropped = report.refused = 1000;
    EXPECT_FALSE(share.isFaulty(report));
}

TEST(PlayedShare, BeginsAnewWhenToldTo)
{
    bridge::PlayedShare share;
    device::DeviceReport report;
    report.lost = 1000;
    EXPECT_TRUE(share.isFaulty(report));
    share.forget(report);
    EXPECT_FALSE(share.isFaulty(report));
}
