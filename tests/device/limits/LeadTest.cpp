#include "device/limits/Lead.h"

#include "device/opening/MultiDevice.h"
#include "tests/device/Fields.h"
#include "tests/device/limits/LoggedDevice.h"
#include "tests/haptics/base/threads/SetClock.h"

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

using namespace midair::device;
using midair::test::SetClock;

// The mute, the cap and the signs of life are the lead's alone, whichever device follows it.
TEST(Lead, IsFollowedByAllThatPlayForIt)
{
    SetClock clock;
    SendLog first(clock), second(clock);
    SafetyLimits limits;
    limits.hold_s = 1.0;
    const auto lead = std::make_shared<Lead>(clock);
    std::vector<MultiDevice::Part> parts(2);
    parts[0] = {guarded(first, limits, 2), 0, 2};
    parts[1] = {guarded(second, limits, 2), 2, 2};
    MultiDevice list(std::move(parts), 4);
    SendLog later(clock);
    std::unique_ptr<GuardedDevice> device;
    list.follow(lead);
    ASSERT_TRUE(list.send(evenField(4, 0, 255)));
    list.setMuted(true);
    EXPECT_TRUE(lead->isMuted());
    EXPECT_EQ(lead->mutes(), 1U) << "it is muted once, however many play for it";
    EXPECT_TRUE(first.all().back().silence);
    EXPECT_TRUE(second.all().back().silence);
    EXPECT_FALSE(list.send(evenField(4, 0, 255)));

    device = guarded(later, limits); // one that is opened meanwhile
    ASSERT_TRUE(device->send(evenField(4, 0, 255)));
    device->follow(lead);
    EXPECT_TRUE(later.all().back().silence) << "what sounded is silenced, too";
    EXPECT_FALSE(device->send(evenField(4, 0, 255)));
    EXPECT_EQ(device->report().state, DeviceState::MUTED);
    list.setMuted(false);
    EXPECT_TRUE(device->send(evenField(4, 0, 255)));
    EXPECT_TRUE(list.send(evenField(4, 0, 255)));

    list.setAmplitudeCap(0.25);
    EXPECT_EQ(lead->amplitudeCap(), 0.25);
    for (SendLog* const log : {&first, &second})
    {
        EXPECT_LE(log->all().back().amplitude, 0.25) << "lowered at once";
        EXPECT_GT(log->all().back().amplitude, 0.2);
    }
    ASSERT_TRUE(device->send(evenField(4, 0, 255)));
    EXPECT_LE(later.all().back().amplitude, 0.25);

    clock.await(3);
    clock.pass(0.9);
    lead->keepAlive();
    clock.pass(0.9);
    for (SendLog* const log : {&first, &second, &later})
        EXPECT_FALSE(log->all().back().silence);
    clock.pass(0.2);
    for (SendLog* const log : {&first, &second, &later})
        EXPECT_TRUE(log->all().back().silence) << "nobody leads any more";
    EXPECT_TRUE(device->isHoldOver() && list.isHoldOver());
}

// What is opened for a lead that has long stood still is silent: opening is no sign of life.
TEST(Lead, ThatStandsStillPlaysNothingOnADeviceThatIsOpenedLate)
{
    SetClock clock;
    SendLog log(clock);
    SafetyLimits limits;
    limits.hold_s = 0.5;
    const auto lead = std::make_shared<Lead>(clock);
    clock.pass(0.6);
    const auto device = guarded(log, limits);
    EXPECT_FALSE(device->isHoldOver()) << "its own lead has just begun";
    device->follow(lead);
    EXPECT_TRUE(device->isHoldOver());
    EXPECT_FALSE(device->sendUnled(evenField(4, 0, 255)));
    lead->keepAlive();
    EXPECT_TRUE(device->sendUnled(evenField(4, 0, 255)));
}

// Whoever muted it by itself didn't mean that it plays for somebody else.
TEST(Lead, IsMutedByADeviceThatWasMutedBefore)
{
    SendLog log;
    const auto device = guarded(log, {});
    device->setMuted(true);
    const auto lead = std::make_shared<Lead>();
    device->follow(lead);
    EXPECT_TRUE(lead->isMuted());
    EXPECT_FALSE(device->send(evenField(4, 0, 255)));
    device->setMuted(false);
    EXPECT_FALSE(lead->isMuted());
    EXPECT_TRUE(device->send(evenField(4, 0, 255)));
}

TEST(Lead, TakesACapThatIsNotUnderstoodForSilence)
{
    Lead lead;
    EXPECT_EQ(lead.amplitudeCap(), 1);
    for (const double wrong : {std::nan(""), -0.1, 1.1, HUGE_VAL})
    {
        lead.setAmplitudeCap(1);
        lead.setAmplitudeCap(wrong);
        EXPECT_EQ(lead.amplitudeCap(), 0) << wrong;
    }
}
