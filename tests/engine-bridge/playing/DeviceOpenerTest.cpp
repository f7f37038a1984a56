// A device that could not be opened is tried again by itself.
#include "device/FieldCounters.h"
#include "engine-bridge/pipeline/HologramThread.h"
#include "tests/Eventually.h"
#include "tests/Halt.h"
#include "tests/engine-bridge/pipeline/Fakes.h"

#include <atomic>
#include <functional>
#include <stdexcept>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

constexpr double kSoon_s = 0.001;

/// Options whose device is not there for the first \a missing times.
HologramOptions lateDevice(const std::shared_ptr<FakeLog>& log,
                           const std::shared_ptr<std::atomic<int>>& tries,
                           int missing)
{
    HologramOptions options = fakeOptions(log);
    options.reopen_s = kSoon_s;
    options.deviceFactory = [log, tries, missing](const std::string&,
                                                  const device::DeviceLayout& layout)
        -> std::unique_ptr<device::ArrayDevice>
    {
        if (++*tries <= missing) throw std::runtime_error("nothing is plugged in");
        return std::make_unique<FakeDevice>(log, layout.transducers);
    };
    return options;
}

/// Tells, while it takes a field, what the thread says of it.
class TellingDevice : public FakeDevice
{
public:
    TellingDevice(std::shared_ptr<FakeLog> log, int transducers, std::function<void()> onPlayed) :
        FakeDevice(std::move(log), transducers),
        _onPlayed(std::move(onPlayed))
    {
    }
    bool send(const device::DriveSignal& signal) override
    {
        FakeDevice::send(signal);
        _counters.countPlayed(base::steadySeconds());
        _onPlayed();
        return true;
    }
    device::DeviceReport report() const override { return _counters.report(); }

private:
    device::FieldCounters _counters;
    std::function<void()> _onPlayed;
};

} // namespace

TEST(DeviceOpener, TriesUntilItIsThereAndThenNoMore)
{
    std::atomic<int> tries{0};
    auto log = std::make_shared<FakeLog>();
    DeviceOpener opener(
        [&]() -> std::unique_ptr<device::ArrayDevice>
        {
            if (++tries < 4) throw std::runtime_error("not yet");
            return std::make_unique<FakeDevice>(log, 3);
        },
        kSoon_s);
    std::uint64_t failures = 0;
    std::string why;
    std::unique_ptr<device::ArrayDevice> device;
    ASSERT_TRUE(eventually(
        [&]
        {
            std::uint64_t failed = 0;
            device = opener.take(failed, why);
            failures += failed;
            return device != nullptr;
        }));
    EXPECT_EQ(failures, 3u);
    EXPECT_EQ(why, "not yet");
    EXPECT_EQ(tries, 4);
}

// An application's factory may throw what is no std::exception.
TEST(DeviceOpener, WhateverIsThrownIsATryThatFailed)
{
    std::atomic<int> tries{0};
    auto log = std::make_shared<FakeLog>();
    DeviceOpener opener(
        [&]() -> std::unique_ptr<device::ArrayDevice>
        {
            if (++tries < 3) throw 5;
            return std::make_unique<FakeDevice>(log, 3);
        },
        kSoon_s);
    std::uint64_t failures = 0;
    std::string why;
    std::unique_ptr<device::ArrayDevice> device;
    ASSERT_TRUE(eventually(
        [&]
        {
            std::uint64_t failed = 0;
            device = opener.take(failed, why);
            failures += failed;
            return device != nullptr;
        }));
    EXPECT_EQ(failures, 2u);
    EXPECT_EQ(why, "something was thrown that is no std::exception");
}

// Nobody looks while it fails; when it is open, why it failed is still known.
TEST(DeviceOpener, TheReasonStaysKnownWhenItOpens)
{
    std::atomic<int> tries{0};
    auto log = std::make_shared<FakeLog>();
    DeviceOpener opener(
        [&]() -> std::unique_ptr<device::ArrayDevice>
        {
            if (++tries == 1) throw std::runtime_error("not yet");
            if (tries == 2) return nullptr;
            return std::make_unique<FakeDevice>(log, 3);
        },
        kSoon_s);
    ASSERT_TRUE(eventually([&] { return tries == 3; }));
    std::uint64_t failures = 0;
    std::string why;
    std::unique_ptr<device::ArrayDevice> device;
    ASSERT_TRUE(eventually(
        [&]
        {
            std::uint64_t failed = 0;
            device = opener.take(failed, why);
            failures += failed;
            return device != nullptr;
        }));
    EXPECT_EQ(failures, 2u);
    EXPECT_EQ(why, "no device was given");
}

TEST(HologramThread, ADeviceFactoryThatThrowsAnythingIsTriedAgain)
{
    auto log = std::make_shared<FakeLog>();
    auto tries = std::make_shared<std::atomic<int>>(0);
    HologramOptions options = fakeOptions(log);
    options.reopen_s = kSoon_s;
    options.deviceFactory =
        [log, tries](const std::string&,
                     const device::DeviceLayout& layout) -> std::unique_ptr<device::ArrayDevice>
    {
        if (++*tries <= 2) throw 5;
        return std::make_unique<FakeDevice>(log, layout.transducers);
    };
    HologramThread thread(options);
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return thread.state() == ArrayState::PLAYING; }));
    const auto result = thread.latestResult();
    ASSERT_FALSE(result->told.empty());
    EXPECT_EQ(result->told[0].code, base::MessageCode::DEVICE_OPEN);
    EXPECT_EQ(result->told[0].text, "something was thrown that is no std::exception");
}

TEST(HologramThread, ADeviceThatComesLateIsPlayedByItself)
{
    auto log = std::make_shared<FakeLog>();
    auto tries = std::make_shared<std::atomic<int>>(0);
    HologramThread thread(lateDevice(log, tries, 3));
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return thread.state() == ArrayState::PLAYING; }));
    EXPECT_GT(log->sends, 0) << "the field of the last snapshot, without another one";
    EXPECT_EQ(*tries, 4) << "and it is not opened once more";
    EXPECT_TRUE(eventually([&] { return thread.latestResult()->told.size() == 2u; }));
    const auto result = thread.latestResult();
    ASSERT_EQ(result->told.size(), 2u);
    EXPECT_EQ(result->told[0].code, base::MessageCode::DEVICE_OPEN);
    EXPECT_EQ(result->told[0].count, 3u) << "told once, and counted";
    EXPECT_EQ(result->told[1].code, base::MessageCode::DEVICE_OPENED);
}

TEST(HologramThread, ADeviceThatComesLateIsMutedAndCapped)
{
    auto log = std::make_shared<FakeLog>();
    auto tries = std::make_shared<std::atomic<int>>(0);
    HologramThread thread(lateDevice(log, tries, 3));
    thread.setMuted(true);
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return thread.state() == ArrayState::MUTED; }));
    EXPECT_EQ(log->sends, 0);
    thread.setMuted(false);
    EXPECT_TRUE(eventually([&] { return log->sends > 0; }));
}

TEST(HologramPipeline, ADeviceThatComesLateKeepsTheCapThatWasLoweredMeanwhile)
{
    std::atomic<bool> isThere{false};
    HologramOptions options;
    options.array = haptics::TransducerArray::octagonalPrism();
    options.reopen_s = kSoon_s;
    options.deviceFactory = [&](const std::string&, const device::DeviceLayout& layout)
    {
        if (!isThere) throw std::runtime_error("nothing is plugged in");
        return device::openDevice("sim:", layout);
    };
    HologramPipeline pipeline(options);
    pipeline.process(squareSnapshot());
    pipeline.device().lowerAmplitudeCap(0.3);
    isThere = true;
    ASSERT_TRUE(eventually([&] { return pipeline.isOpenedNow(); }));
    const auto result = pipeline.process(squareSnapshot());
    EXPECT_TRUE(result->playing);
    EXPECT_LE(result->played().cwiseAbs().maxCoeff(), 0.3f);
}

// Frames are handed over and solved as fast as ever, and there is one message.
TEST(HologramThread, ADeviceThatNeverOpensHoldsNothingUp)
{
    auto log = std::make_shared<FakeLog>();
    auto inOpen = std::make_shared<std::atomic<bool>>(false);
    auto open = std::make_shared<Halt>(true);
    HologramOptions options = fakeOptions(log);
    options.reopen_s = kSoon_s;
    auto tries = std::make_shared<std::atomic<int>>(0);
    options.deviceFactory = [=](const std::string&,
                                const device::DeviceLayout&) -> std::unique_ptr<device::ArrayDevice>
    {
        if (++*tries > 1)
        {
            *inOpen = true;
            open->pass();
        }
        throw std::runtime_error("try " + std::to_string(*tries));
    };
    HologramThread thread(options);
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return inOpen->load(); }));
    for (unsigned int frame = 1; frame <= 20; ++frame)
    {
        snapshot = squareSnapshot(1e-3 * frame);
        snapshot.frame = frame;
        thread.submit(snapshot);
        // the first result may still be on its way
        ASSERT_TRUE(eventually(
            [&] { return thread.latestResult() && thread.latestResult()->frame == frame; }))
            << "while the device is being opened";
    }
    EXPECT_EQ(thread.latestResult()->told.size(), 1u);
    EXPECT_EQ(thread.reading().state, ArrayState::CLOSED);
    *open = false;
}

TEST(HologramThread, StateAndCountersAreOfOneReading)
{
    auto log = std::make_shared<FakeLog>();
    HologramThread* asked = nullptr;
    ArrayReading during;
    HologramOptions options = fakeOptions(log);
    options.deviceFactory = [&](const std::string&, const device::DeviceLayout& layout)
    {
        return std::make_unique<TellingDevice>(
            log, layout.transducers, [&] { during = asked->reading(); });
    };
    HologramThread thread(options);
    asked = &thread;
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([&] { return thread.results() > 0; }));
    EXPECT_EQ(during.fields.played, 1u) << "before there is a result";
    EXPECT_EQ(during.state, ArrayState::PLAYING) << stateName(during.state);
    const ArrayReading after = thread.reading();
    EXPECT_EQ(after.state, ArrayState::PLAYING);
    EXPECT_EQ(after.fields.played, 1u);
}
