#include "device/limits/GuardedDevice.h"

#include "device/FieldCounters.h"
#include "device/drive/DriveEncoder.h"
#include "tests/Eventually.h"
#include "tests/device/Fields.h"
#include "tests/device/limits/LoggedDevice.h"
#include "tests/haptics/base/threads/SetClock.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

#include <gtest/gtest.h>

using namespace midair::device;
using midair::test::SetClock;

namespace
{

std::string limitsError(const SafetyLimits& limits)
{
    SendLog log;
    try
    {
        guarded(log, limits);
    }
    catch (const DeviceError& error)
    {
        return error.what();
    }
    return "no error";
}

} // namespace

TEST(ScaleDuties, never_exceeds_and_is_close_below)
{
    for (const double gain : {0.0, 0.013, 0.2, 0.5, 0.77, 0.999, 1.0})
        for (int duty = 0; duty < 256; ++duty)
        {
            DriveSignal scaled;
            scaleDuties(evenField(1, 77, static_cast<std::uint8_t>(duty)), gain, scaled);
            const double wanted = gain * amplitudeLevels()[duty];
            const double got = amplitudeLevels()[scaled.duty[0]];
            EXPECT_LE(got, wanted + 1e-7);              // single precision of the table
            EXPECT_GE(got, wanted - M_PI / 510 - 1e-7); // one level
            EXPECT_EQ(scaled.phase[0], 77);
        }
    DriveSignal same;
    scaleDuties(randomField(300, 1), 1, same);
    EXPECT_EQ(same, randomField(300, 1));
}

TEST(GuardedDevice, caps_the_amplitude_and_keeps_the_shape)
{
    SendLog log;
    SafetyLimits limits;
    limits.maxAmplitude = 0.3;
    const auto device = guarded(log, limits);
    DriveSignal field = evenField(4, 0, 255);
    field.duty[0] = 85; // one half, where the peak is 1
    ASSERT_TRUE(device->send(field));
    EXPECT_NEAR(log.all().back().amplitude, 0.15, M_PI / 510); // one level
    EXPECT_LE(log.all().back().amplitude, 0.15);
    ASSERT_TRUE(device->send(evenField(4, 0, 40))); // 0.24: under the cap
    EXPECT_FLOAT_EQ(static_cast<float>(log.all().back().amplitude), amplitudeLevels()[40]);
}

TEST(GuardedDevice, ramps_up_at_the_start)
{
    SetClock clock;
    SendLog log(clock);
    SafetyLimits limits;
    limits.ramp_s = 0.1;
    const auto device = guarded(log, limits);
    clock.await(1);
    ASSERT_TRUE(device->send(evenField(4, 0, 255)));
    clock.pass(0.3);
    const auto events = log.all();
    ASSERT_GT(events.size(), 30U) << "smoothly";
    EXPECT_EQ(events.front().amplitude, 0);
    EXPECT_EQ(events.back().amplitude, 1);
    EXPECT_NEAR(events.back().time_s - events.front().time_s, 0.1, 0.003);
    for (const SendLog::Event& event : events)
    {
        // Never ahead of the ramp, and no more behind it than a duty level.
        const double ramp = (event.time_s - events[0].time_s) / limits.ramp_s;
        EXPECT_LE(event.amplitude, std::min(ramp, 1.0) + 1e-6);
        EXPECT_GE(event.amplitude, std::min(ramp, 1.0) - M_PI / 510);
    }
    device->silence(); // or closing would wait for time to pass
}

// The last step but one may end within what is too small for a new field, below the cap.
TEST(GuardedDevice, ramps_up_to_the_cap_whatever_the_last_step)
{
    for (const double ramp_s : {0.02, 0.0203, 0.0207, 0.05, 0.0999, 0.1001, 0.333})
    {
        SCOPED_TRACE(ramp_s);
        SetClock clock;
        SendLog log(clock);
        SafetyLimits limits;
        limits.ramp_s = ramp_s;
        limits.maxAmplitude = 0.3;
        const auto device = guarded(log, limits);
        clock.await(1);
        ASSERT_TRUE(device->send(evenField(4, 0, 255)));
        clock.pass(ramp_s - 0.0001);
        clock.pass(0.1);
        double most = 0; // what a device can play below the cap
        for (const double level : amplitudeLevels())
            if (level <= 0.3) most = std::max(most, level);
        EXPECT_NEAR(log.all().back().amplitude, most, 1e-9);
        EXPECT_EQ(device->status().find("limited to 29.9"), std::string::npos) << device->status();
        device->silence(); // or closing would wait for time to pass
    }
}

TEST(GuardedDevice, ramps_down_at_the_end)
{
    SendLog log; // closing waits for time to pass
    SafetyLimits limits;
    limits.ramp_s = 0.5; // some steps come on a busy machine, too
    auto device = guarded(log, limits);
    ASSERT_TRUE(device->send(evenField(4, 0, 255)));
    ASSERT_TRUE(eventually([&] { return log.all().back().amplitude == 1; }));
    const std::size_t rising = log.all().size();
    device.reset();
    const auto events = log.all();
    ASSERT_GT(events.size(), rising + 3);
    EXPECT_TRUE(events.back().silence);
    for (std::size_t i = rising + 1; i < events.size(); ++i)
        EXPECT_LE(events[i].amplitude, events[i - 1].amplitude);
}

TEST(GuardedDevice, starts_a_new_ramp_after_silence)
{
    SetClock clock;
    SendLog log(clock);
    SafetyLimits limits;
    limits.ramp_s = 0.02;
    const auto device = guarded(log, limits);
    clock.await(1);
    ASSERT_TRUE(device->send(evenField(4, 0, 255)));
    clock.pass(0.1);
    EXPECT_EQ(log.all().back().amplitude, 1);
    device->silence();
    EXPECT_TRUE(log.all().back().silence); // at once, no ramp
    ASSERT_TRUE(device->send(evenField(4, 0, 255)));
    EXPECT_EQ(log.all().back().amplitude, 0);
    clock.pass(0.01);
    EXPECT_NEAR(log.all().back().amplitude, 0.5, 0.15);
    device->silence(); // or closing would wait for time to pass
}

TEST(LimitedDrive, a_field_that_is_refused_leaves_the_one_before_in_the_budget)
{
    SafetyLimits limits;
    limits.meanDrive = 0.25;
    limits.meanDriveTime_s = 1.0;
    LimitedDrive drive(limits, 0.0);
    drive.want(evenField(4, 0, 255));
    EXPECT_EQ(drive.lowered(1.0, 0.0).duty.front(), 255);
    drive.noteSent(true);
    for (int k = 1; k <= 100; ++k)
    {
        drive.want(evenField(4, 0, 1));
        drive.lowered(1.0, 0.1 * k);
        drive.noteSent(false);
    }
    drive.want(evenField(4, 0, 255));
    EXPECT_NEAR(drive.allowed(1.0, 10.0), 0.5, 1e-3) << "it has sounded at full drive for 10 s";
}

TEST(GuardedDevice, keeps_the_mean_drive_within_the_budget)
{
    for (const bool isSentAgain : {true, false})
    {
        SetClock clock;
        SendLog log(clock);
        SafetyLimits limits;
        limits.meanDrive = 0.25;
        limits.meanDriveTime_s = 0.3;
        const auto device = guarded(log, limits);
        clock.await(1);
        ASSERT_TRUE(device->send(evenField(4, 0, 255)));
        for (int k = 0; k < 100; ++k)
        {
            if (isSentAgain)
            {
                ASSERT_TRUE(device->send(evenField(4, 0, 255)));
            }
            clock.pass(0.01);
        }
        // The mean, recomputed from what reached the device: dE/dt = (P - E)/tau.
        const auto events = log.all();
        EXPECT_EQ(events.front().amplitude, 1); // loud as long as the budget lasts
        double mean = 0;
        double worst = 0;
        for (std::size_t i = 0; i < events.size(); ++i)
        {
            const double until_s = i + 1 < events.size() ? events[i + 1].time_s : clock.now_s();
            const double drive = events[i].amplitude * events[i].amplitude;
            const double decay = std::exp(-(until_s - events[i].time_s) / limits.meanDriveTime_s);
            mean = drive + (mean - drive) * decay;
            worst = std::max(worst, mean);
        }
        EXPECT_LE(worst, limits.meanDrive) << isSentAgain;
        EXPECT_NEAR(mean, limits.meanDrive, 0.01) << isSentAgain; // and it is used
    }
}

TEST(GuardedDevice, reduces_a_field_that_is_held)
{
    SetClock clock;
    SendLog log(clock);
    SafetyLimits limits;
    limits.meanDrive = 0.25;
    limits.meanDriveTime_s = 0.1;
    const auto device = guarded(log, limits);
    clock.await(1);
    ASSERT_TRUE(device->send(evenField(4, 0, 255)));
    clock.pass(0.5);
    EXPECT_NEAR(log.all().back().amplitude, 0.5, 0.01); // sqrt(0.25)
}

TEST(GuardedDevice, silences_a_field_that_nobody_renews_when_asked_to)
{
    SetClock clock;
    SendLog log(clock);
    SafetyLimits limits;
    limits.hold_s = 0.05;
    const auto device = guarded(log, limits);
    clock.await(1);
    for (int k = 0; k < 10; ++k)
    {
        ASSERT_TRUE(device->send(evenField(4, 0, 255)));
        clock.pass(0.049);
        EXPECT_FALSE(log.all().back().silence) << "renewed in time";
    }
    const double sent_s = log.all().back().time_s;
    clock.pass(0.2);
    EXPECT_TRUE(log.all().back().silence);
    EXPECT_NEAR(log.all().back().time_s - sent_s, 0.0505, 1e-6);
}

TEST(GuardedDevice, stays_muted_until_it_is_lifted)
{
    SendLog log;
    const auto device = guarded(log, {});
    ASSERT_TRUE(device->send(evenField(4, 0, 255)));
    std::thread([&] { device->setMuted(true); }).join();
    EXPECT_TRUE(log.all().back().silence);
    const std::size_t events = log.all().size();
    EXPECT_FALSE(device->send(evenField(4, 0, 255)));
    EXPECT_EQ(log.all().size(), events);
    EXPECT_EQ(device->report().state, DeviceState::MUTED);
    EXPECT_EQ(device->report().refused, 1U);
    EXPECT_EQ(device->status(), "logged; muted");
    device->setMuted(false);
    EXPECT_TRUE(device->send(evenField(4, 0, 255)));
}

TEST(GuardedDevice, no_field_follows_a_mute_however_the_threads_meet)
{
    SendLog log;
    SafetyLimits limits;
    limits.ramp_s = 0.01; // so that its own thread sends too
    const auto device = guarded(log, limits);
    for (int round = 0; round < 30; ++round)
    {
        std::atomic<bool> stop{false};
        std::thread sender(
            [&]
            {
                while (!stop)
                    device->send(evenField(4, 0, 255));
            });
        EXPECT_TRUE(
            eventually([&, before = log.all().size()] { return log.all().size() > before; }));
        device->setMuted(true);
        const std::size_t events = log.all().size();
        EXPECT_TRUE(log.all().back().silence);
        EXPECT_TRUE(eventually([&, before = device->report().refused]
                               { return device->report().refused > before + 3; }));
        EXPECT_EQ(log.all().size(), events);
        stop = true;
        sender.join();
        device->setMuted(false);
    }
}

TEST(GuardedDevice, names_limits_that_are_out_of_range)
{
    SafetyLimits limits;
    limits.maxAmplitude = 1.5;
    EXPECT_EQ(limitsError(limits), "device limits: maxAmplitude is 1.5; it must be within 0 .. 1");
    limits = {};
    limits.ramp_s = -1;
    EXPECT_EQ(limitsError(limits), "device limits: ramp is -1 s; it must be within 0 .. 10");
    limits = {};
    limits.meanDrive = std::nan("");
    EXPECT_EQ(limitsError(limits), "device limits: meanDrive is nan; it must be within 0 .. 1");
    limits = {};
    limits.meanDriveTime_s = 0;
    EXPECT_EQ(limitsError(limits), "device limits: meanDriveTime is 0 s; it must be above 0");
    limits = {};
    limits.hold_s = -1;
    EXPECT_EQ(limitsError(limits), "device limits: hold is -1 s; it must be at least 0");
    limits = {};
    limits.maxPressure_Pa = -1;
    EXPECT_EQ(limitsError(limits),
              "device limits: maxPressure is -1 Pa; it must be within 0 .. 1e+06");
}

TEST(GuardedDevice, takes_the_stricter_of_program_and_uri)
{
    SafetyLimits limits;
    limits.maxAmplitude = 0.5;
    const auto first = openLimitedDevice("null:?max-amplitude=0.9", {1, {}}, limits);
    ASSERT_TRUE(first->send(evenField(1, 0, 255)));
    EXPECT_NEAR(std::abs(first->played()[0]), 0.5, M_PI / 510); // one level
    const auto second = openLimitedDevice("null:?max-amplitude=0.2", {1, {}}, limits);
    ASSERT_TRUE(second->send(evenField(1, 0, 255)));
    EXPECT_NEAR(std::abs(second->played()[0]), 0.2, M_PI / 510);
    EXPECT_LE(std::abs(second->played()[0]), 0.2F);
}

TEST(GuardedDevice, tells_the_cap_of_pressure_to_who_knows_the_points)
{
    const auto cap = [](const std::string& uri, double program_Pa)
    {
        SafetyLimits limits;
        limits.maxPressure_Pa = program_Pa;
        return openLimitedDevice(uri, {2, {0, 1}}, limits)->ability().maxPressure_Pa;
    };
    EXPECT_EQ(cap("null:", 0), 0);
    EXPECT_EQ(cap("null:", 700), 700);
    EXPECT_EQ(cap("null:?max-pressure=500", 0), 500);
    EXPECT_EQ(cap("null:?max-pressure=500", 700), 500);
    EXPECT_EQ(cap("null:?max-pressure=900", 700), 700);
    EXPECT_EQ(cap("null:?boards=0,null:?boards=1&max-pressure=400", 0), 400);
}

// A cap that comes while the device is open.
TEST(GuardedDevice, lowers_what_sounds_to_a_stricter_cap_at_once)
{
    SendLog log;
    SafetyLimits limits;
    limits.maxAmplitude = 0.8;
    const auto device = guarded(log, limits);
    EXPECT_TRUE(device->setAmplitudeCap(0.5));
    EXPECT_TRUE(log.all().empty()) << "nothing sounds";
    ASSERT_TRUE(device->send(evenField(4, 0, 255)));
    EXPECT_NEAR(log.all().back().amplitude, 0.5, M_PI / 510);
    ASSERT_TRUE(device->setAmplitudeCap(0.2));
    EXPECT_NEAR(log.all().back().amplitude, 0.2, M_PI / 510);
    EXPECT_LE(log.all().back().amplitude, 0.2);
    const std::size_t events = log.all().size();
    ASSERT_TRUE(device->setAmplitudeCap(1));
    EXPECT_EQ(log.all().size(), events) << "the next field is louder, not this one";
    ASSERT_TRUE(device->send(evenField(4, 0, 255)));
    EXPECT_NEAR(log.all().back().amplitude, 0.8, M_PI / 510) << "what it was opened with";
    ASSERT_TRUE(device->setAmplitudeCap(std::nan("")));
    EXPECT_EQ(log.all().back().amplitude, 0) << "what isn't understood is silent";
}
