// What was asked to become quieter and isn't confirmed is silence.
#include "device/limits/QuietWatch.h"

#include "device/limits/GuardedDevice.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/Eventually.h"
#include "tests/device/Fields.h"
#include "tests/haptics/base/threads/SetClock.h"

#include <atomic>
#include <mutex>
#include <thread>

#include <gtest/gtest.h>

using namespace midair::device;
using midair::test::SetClock;

namespace
{

Loudness level(int duty)
{
    return Loudness::of(evenField(4, 0, static_cast<std::uint8_t>(duty)));
}

/// A device that tells late, or never, what has become of what it was asked for.
class SlowDevice : public ArrayDevice
{
public:
    struct Far
    {
        explicit Far(const midair::base::Clock& itsClock = midair::base::steadyClock()) :
            clock(itsClock)
        {
        }

        const midair::base::Clock& clock;
        std::mutex mutex;
        int sounding = 0;  ///< duty level at the far side
        bool works = true; ///< what is asked for is carried out
        bool canSilence = true;
        bool refuses = false;
        double confirmed_s = 0;
        std::atomic<int> silences{0};
        double rate = 0;

        int heard()
        {
            const std::lock_guard<std::mutex> lock(mutex);
            return sounding;
        }
        void set(bool& what, bool to)
        {
            const std::lock_guard<std::mutex> lock(mutex);
            what = to;
        }
    };

    explicit SlowDevice(Far& far) : _far(far) {}
    bool send(const DriveSignal& signal) override
    {
        const std::lock_guard<std::mutex> lock(_far.mutex);
        if (_far.refuses) return false;
        if (!_far.works) return true;
        _far.sounding = signal.duty[0];
        _far.confirmed_s = _far.clock.now_s();
        return true;
    }
    void silence() override
    {
        ++_far.silences;
        const std::lock_guard<std::mutex> lock(_far.mutex);
        if (!_far.canSilence) return;
        _far.sounding = 0;
        _far.confirmed_s = _far.clock.now_s();
    }
    double confirmed_s() const override
    {
        const std::lock_guard<std::mutex> lock(_far.mutex);
        return _far.confirmed_s;
    }
    std::string status() const override { return "slow"; }
    DeviceReport report() const override { return {}; }
    DriveAbility ability() const override
    {
        DriveAbility ability;
        ability.fieldsPerSecond = _far.rate;
        return ability;
    }
    std::vector<std::complex<float>> played() const override { return {}; }

private:
    Far& _far;
};

std::unique_ptr<GuardedDevice> guarded(SlowDevice::Far& far)
{
    return std::make_unique<GuardedDevice>(std::make_unique<SlowDevice>(far),
                                           SafetyLimits(),
                                           4,
                                           std::unique_ptr<DeviceClaim>(),
                                           far.clock);
}

} // namespace

TEST(QuietWatch, WaitsForWhatIsQuieterAlone)
{
    QuietWatch watch;
    watch.ask(level(100), 1, true);
    EXPECT_EQ(watch.since_s(), 0) << "louder than silence";
    watch.confirm(1);
    watch.ask(level(100), 2, true);
    watch.ask(level(200), 3, true);
    EXPECT_EQ(watch.since_s(), 0);
    watch.ask(level(150), 4, true);
    EXPECT_EQ(watch.since_s(), 4) << "200 may sound by now, which isn't confirmed";
    watch.confirm(3);
    EXPECT_EQ(watch.since_s(), 4);
    watch.confirm(4);
    EXPECT_EQ(watch.since_s(), 0);
    EXPECT_TRUE(watch.sounds());
    watch.askSilence(5);
    EXPECT_EQ(watch.since_s(), 5);
    EXPECT_TRUE(watch.maySound());
    watch.confirm(5);
    EXPECT_FALSE(watch.maySound());
}

TEST(QuietWatch, TakesOneQuietTransducerForQuieter)
{
    DriveSignal field = evenField(4, 0, 200);
    QuietWatch watch;
    watch.ask(Loudness::of(field), 1, true);
    watch.confirm(1);
    field.duty[2] = 0;
    watch.ask(Loudness::of(field), 2, true);
    EXPECT_EQ(watch.since_s(), 2) << "the largest level is the same";
}

TEST(QuietWatch, WhatWasRefusedIsNotConfirmedHoweverSyncTheDeviceIs)
{
    const double all_s = std::numeric_limits<double>::infinity();
    QuietWatch watch;
    watch.ask(level(200), 1, true);
    watch.confirm(all_s);
    watch.ask(level(100), 2, false);
    watch.confirm(all_s);
    EXPECT_EQ(watch.since_s(), 2);
    EXPECT_TRUE(watch.isOverdue(2.11, QuietWatch::kConfirm_s));
    EXPECT_FALSE(watch.isOverdue(2.09, QuietWatch::kConfirm_s));
    watch.ask(level(100), 3, true); // the next one is taken
    watch.confirm(all_s);
    EXPECT_EQ(watch.since_s(), 0);
}

TEST(QuietWatch, AStreamIsDueFromItsOldestUnconfirmedStep)
{
    QuietWatch watch;
    double time_s = 10;
    for (int k = 0; k < 1000; ++k, time_s += 1e-3) // loud and quiet in turn, confirmed 20 ms later
    {
        watch.confirm(time_s - 0.02);
        EXPECT_FALSE(watch.isOverdue(time_s, 0.03));
        watch.ask(level(k % 2 == 0 ? 200 : 50), time_s, true);
    }
    const double end_s = time_s;
    for (int k = 0; k < 120; ++k, time_s += 1e-3) // nothing is any more
    {
        watch.confirm(end_s - 0.02);
        watch.ask(level(k % 2 == 0 ? 200 : 50), time_s, true);
    }
    EXPECT_TRUE(watch.isOverdue(time_s, QuietWatch::kConfirm_s));
}

TEST(QuietWatch, DoubtLastsUntilASilenceIsConfirmed)
{
    QuietWatch watch;
    watch.ask(level(200), 1, true);
    watch.confirm(1);
    watch.ask(level(100), 2, true);
    watch.doubt(2.1);
    EXPECT_EQ(watch.doubted_s(), 2);
    EXPECT_TRUE(watch.isSilence());
    EXPECT_FALSE(watch.isOverdue(2.15, QuietWatch::kConfirm_s));
    watch.doubt(2.21);
    EXPECT_EQ(watch.doubted_s(), 2) << "since it was asked for first";
    watch.confirm(2.21);
    EXPECT_EQ(watch.doubted_s(), 0);
    EXPECT_FALSE(watch.maySound());
}

TEST(QuietWatch, ASilenceMayTakeLongerThanTheTimeUntilItIsAskedForAgain)
{
    for (const bool isLed : {false, true}) // whoever leads sends on meanwhile
    {
        QuietWatch watch;
        watch.ask(level(200), 1, true);
        watch.confirm(1);
        watch.ask(level(100), 2, true);
        for (double now_s = 2.11; now_s < 2.9; now_s += 0.1)
        {
            watch.doubt(now_s);
            if (isLed) watch.ask(level(100), now_s + 0.01, true);
        }
        EXPECT_EQ(watch.doubted_s(), 2);
        watch.confirm(2.11); // the first silence
        EXPECT_EQ(watch.doubted_s(), 0);
        EXPECT_EQ(watch.since_s(), isLed ? 2.21 : 0) << "a silence has come after a field";
        EXPECT_EQ(watch.maySound(), isLed);
    }
}

// Whatever makes it quieter, on a device that doesn't carry it out, or refuses it.
TEST(QuieterField, IsSilenceWhereItIsNotConfirmed)
{
    const std::vector<std::pair<const char*, std::function<void(GuardedDevice&)>>> ways = {
        {"cap", [](GuardedDevice& device) { device.setAmplitudeCap(0.2); }},
        {"field", [](GuardedDevice& device) { device.send(evenField(4, 0, 40)); }},
        {"step", [](GuardedDevice& device) { device.sendUnled(evenField(4, 0, 40)); }},
    };
    for (const auto& [name, quieten] : ways)
        for (const bool refuses : {false, true})
        {
            SCOPED_TRACE(std::string(name) + (refuses ? ", refused" : ", not carried out"));
            SetClock clock;
            SlowDevice::Far far(clock);
            const auto device = guarded(far);
            ASSERT_TRUE(device->send(evenField(4, 0, 255)));
            clock.pass(0.5);
            far.set(refuses ? far.refuses : far.works, refuses);
            quieten(*device);
            const bool isAtOnce = refuses && name == std::string("cap"); // and no fault
            EXPECT_EQ(far.heard(), isAtOnce ? 0 : 255);
            if (isAtOnce) continue;
            clock.await(1);
            clock.pass(0.0999);
            EXPECT_EQ(far.heard(), 255);
            EXPECT_EQ(device->report().quieted, "");
            clock.pass(0.001);
            EXPECT_EQ(far.heard(), 0);
            EXPECT_EQ(device->report().quieted,
                      "a quieter field wasn't confirmed within 100 ms, so it is silenced");
            EXPECT_EQ(device->report().unsilenced, "");
            EXPECT_EQ(device->report().faults, 1U);
            EXPECT_EQ(device->report().silences, 1U);
            // It plays again as soon as it does what it is told.
            far.set(far.refuses, false);
            far.set(far.works, true);
            ASSERT_TRUE(device->setAmplitudeCap(1));
            ASSERT_TRUE(device->send(evenField(4, 0, 40)));
            EXPECT_EQ(far.heard(), 40);
            EXPECT_EQ(device->report().quieted, "");
        }
}

TEST(QuieterField, WhoseSilenceIsNotConfirmedEitherIsAFaultAndIsTriedAgain)
{
    const std::vector<std::pair<const char*, std::function<void(GuardedDevice&)>>> ways = {
        {"cap", [](GuardedDevice& device) { device.setAmplitudeCap(0.2); }},
        {"mute", [](GuardedDevice& device) { device.setMuted(true); }},
        {"silence", [](GuardedDevice& device) { device.silence(); }},
    };
    for (const auto& [name, quieten] : ways)
    {
        SCOPED_TRACE(name);
        SetClock clock;
        SlowDevice::Far far(clock);
        const auto device = guarded(far);
        ASSERT_TRUE(device->send(evenField(4, 0, 255)));
        clock.pass(0.5);
        far.set(far.works, false);
        far.set(far.canSilence, false);
        quieten(*device);
        clock.await(1);
        clock.pass(0.0999);
        EXPECT_EQ(device->report().unsilenced, "");
        // A cap is a quieter field first, whose silence is another 100 ms late.
        clock.pass(name == std::string("cap") ? 0.103 : 0.001);
        EXPECT_NE(device->report().unsilenced, "");
        clock.pass(0.75);
        EXPECT_LT(device->report().state, DeviceState::HANGING);
        clock.pass(0.25);
        EXPECT_EQ(device->report().state, DeviceState::HANGING);
        EXPECT_EQ(device->report().message, device->report().unsilenced);
        const int tries = far.silences;
        clock.pass(0.303);
        EXPECT_EQ(far.silences, tries + 3) << "it is tried again";
        EXPECT_EQ(far.heard(), 255);
        far.set(far.canSilence, true);
        clock.pass(0.102);
        EXPECT_EQ(far.heard(), 0);
        EXPECT_EQ(device->report().unsilenced, "");
        EXPECT_LT(device->report().state, DeviceState::HANGING);
        const int last = far.silences;
        clock.pass(0.25);
        EXPECT_EQ(far.silences, last) << "it is silent";
    }
}

TEST(QuieterField, OfASlowLineHasTheTimeThatTheLineNeeds)
{
    SetClock clock;
    SlowDevice::Far far(clock);
    far.rate = 5; // 200 ms a field
    const auto device = guarded(far);
    ASSERT_TRUE(device->send(evenField(4, 0, 255)));
    clock.pass(0.5);
    far.set(far.works, false);
    ASSERT_TRUE(device->send(evenField(4, 0, 40)));
    clock.await(1);
    clock.pass(0.499);
    EXPECT_EQ(far.heard(), 255);
    clock.pass(0.002);
    EXPECT_EQ(far.heard(), 0);
}

TEST(QuieterField, ThatIsConfirmedCostsNoThread)
{
    SlowDevice::Far far;
    const auto device = guarded(far);
    for (int k = 0; k < 50; ++k)
    {
        ASSERT_TRUE(device->send(evenField(4, 0, k % 2 == 0 ? 255 : 40)));
        EXPECT_EQ(far.heard(), k % 2 == 0 ? 255 : 40);
    }
    device->silence();
    EXPECT_EQ(device->report().faults, 0U);
    EXPECT_EQ(device->report().quieted + device->report().unsilenced, "");
}

// A hold that nobody resets: each step of a player is refused, and none is a sign of life.
TEST(Hold, IsOverWhateverAPlayerSends)
{
    SetClock clock;
    SlowDevice::Far far(clock);
    SafetyLimits limits;
    limits.hold_s = 0.1;
    GuardedDevice device(std::make_unique<SlowDevice>(far), limits, 4, {}, clock);
    clock.await(1);
    const double start_s = clock.now_s();
    double heard_s = start_s;
    int refused = 0;
    while (clock.now_s() - start_s < 0.4)
    {
        refused += device.sendUnled(evenField(4, 0, 255)) ? 0 : 1;
        if (far.heard() > 0) heard_s = clock.now_s();
        clock.pass(5e-3);
    }
    EXPECT_NEAR(heard_s - start_s, 0.1, 5.5e-3);
    EXPECT_NEAR(refused, 59, 1);
    EXPECT_TRUE(device.isHoldOver());
    EXPECT_EQ(device.report().silences, 1U);
    EXPECT_NE(device.status().find("no sign of life"), std::string::npos) << device.status();
    device.keepAlive();
    EXPECT_FALSE(device.isHoldOver());
    EXPECT_EQ(far.heard(), 0) << "the word alone plays nothing";
    const auto older = std::make_shared<Lead>(clock);
    clock.pass(0.05);
    device.keepAlive();
    EXPECT_TRUE(device.sendUnled(evenField(4, 0, 255)));
    EXPECT_EQ(far.heard(), 255);
    device.follow(older); // an older sign is known to be the last
    clock.pass(0.049);
    EXPECT_EQ(far.heard(), 255);
    clock.pass(0.002);
    EXPECT_EQ(far.heard(), 0);
    EXPECT_FALSE(device.sendUnled(evenField(4, 0, 9)));
    EXPECT_TRUE(device.send(evenField(4, 0, 77))) << "whoever leads sends";
    EXPECT_EQ(far.heard(), 77);
}

TEST(Hold, OfOneInAListIsThatOfAll)
{
    const auto device = openDevice("sim:?boards=0,sim:?boards=1&hold=100ms", {2, {0, 1}});
    ASSERT_TRUE(device->send(evenField(2, 0, 255)));
    const auto sounding = [&]
    {
        const auto q = device->played();
        return std::abs(q[0]) + std::abs(q[1]);
    };
    EXPECT_NEAR(sounding(), 2, 1e-6);
    EXPECT_TRUE(eventually([&] { return sounding() == 0; })) << "both";
    EXPECT_TRUE(device->isHoldOver());
    EXPECT_FALSE(device->sendUnled(evenField(2, 0, 255)));
    device->keepAlive();
    EXPECT_TRUE(device->sendUnled(evenField(2, 0, 255)));
}
