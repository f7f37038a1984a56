#include "samples/shared/views/Signals.h"

#include <csignal>
#include <vector>

#include <gtest/gtest.h>

using namespace midair::samples;

namespace
{

/// What \a signals make of the mute, the last of them at the latest when it ends.
std::vector<bool> followed(const std::vector<int>& signals)
{
    std::vector<bool> mutes;
    MuteSignals follows([&](bool isMuted) { mutes.push_back(isMuted); });
    for (const int number : signals)
        std::raise(number);
    follows.end();
    std::raise(SIGUSR1); // nobody follows it
    return mutes;
}

} // namespace

TEST(MuteSignal, MutesAndLetsPlayWithoutAFrame)
{
    catchMuteSignals();
    EXPECT_TRUE(followed({}).empty());
    EXPECT_EQ(followed({}), std::vector<bool>{true}) << "came while nobody followed";
    EXPECT_EQ(followed({SIGUSR2}).back(), false);
    EXPECT_EQ(followed({SIGUSR2, SIGUSR1}).back(), true) << "the newest";
    EXPECT_EQ(followed({SIGUSR1, SIGUSR2}).back(), false);
}

TEST(MuteSignal, WhatIsFollowedIsKeptAndSoIsWhatOthersDid)
{
    catchMuteSignals();
    MuteSignals([](bool) {}).end(); // what came before
    int kept = 0;
    {
        MuteSignals follows([](bool) {}, [&] { ++kept; });
        follows.end();
        EXPECT_EQ(kept, 0) << "an end changes nothing";
    }
    MuteSignals follows([](bool) {}, [&] { ++kept; });
    follows.wake();
    follows.end();
    EXPECT_EQ(kept, 1);
}
