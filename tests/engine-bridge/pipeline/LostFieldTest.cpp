// A scene that stands still brings no next field: the pipeline sends the last one again where the
// device has lost it.
#include "engine-bridge/pipeline/HologramThread.h"
#include "tests/Eventually.h"
#include "tests/engine-bridge/pipeline/Fakes.h"

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

bool sounds(const HologramResult& result)
{
    return result.played().cwiseAbs().maxCoeff() > 0.0f;
}

HologramOptions simulated(const std::string& uri)
{
    HologramOptions options = fakeOptions(std::make_shared<FakeLog>());
    options.deviceFactory = nullptr;
    options.deviceUri = uri;
    return options;
}

/// Counts in its report what the test says.
class FaultyDevice : public FakeDevice
{
public:
    FaultyDevice(std::shared_ptr<FakeLog> log,
                 int transducers,
                 std::shared_ptr<device::DeviceReport> report) :
        FakeDevice(std::move(log), transducers),
        _report(std::move(report))
    {
    }
    device::DeviceReport report() const override { return *_report; }

private:
    std::shared_ptr<device::DeviceReport> _report;
};

struct LostField : testing::Test
{
    std::shared_ptr<FakeLog> log = std::make_shared<FakeLog>();
    std::shared_ptr<device::DeviceReport> report = std::make_shared<device::DeviceReport>();
    HologramPipeline pipeline{options()};

    HologramOptions options() const
    {
        HologramOptions options = fakeOptions(log);
        options.deviceFactory =
            [log = log, report = report](const std::string&, const device::DeviceLayout& layout)
        { return std::make_unique<FaultyDevice>(log, layout.transducers, report); };
        return options;
    }
};

} // namespace

TEST_F(LostField, IsNotMissedWhileAllIsWell)
{
    EXPECT_EQ(pipeline.attend(), nullptr) << "nothing was played yet";
    pipeline.process(squareSnapshot());
    EXPECT_EQ(pipeline.attend(), nullptr);
    pipeline.process(SceneSnapshot());
    ++report->faults;
    EXPECT_EQ(pipeline.attend(), nullptr) << "nothing is to be played";
    EXPECT_EQ(log->sends, 1);
}

TEST_F(LostField, IsSentAgainAfterAWatchdogOrALoss)
{
    const auto first = pipeline.process(squareSnapshot());
    ++report->faults;
    const auto again = pipeline.attend();
    ASSERT_NE(again, nullptr);
    EXPECT_EQ(log->sends, 2);
    EXPECT_EQ(log->solves, 1);
    EXPECT_TRUE(again->playing);
    EXPECT_EQ(again->played(), first->played());
    EXPECT_EQ(again->counters.resent, 1u);
    EXPECT_EQ(pipeline.attend(), nullptr) << "once for a fault";
    ++report->lost;
    report->pending = 1;
    EXPECT_EQ(pipeline.attend(), nullptr) << "one is still on its way";
    report->pending = 0;
    EXPECT_NE(pipeline.attend(), nullptr);
    ++report->reconnects;
    EXPECT_NE(pipeline.attend(), nullptr);
    EXPECT_EQ(log->sends, 4);
}

TEST_F(LostField, OfADeviceThatIsGoneWaitsUntilItIsBack)
{
    pipeline.process(squareSnapshot());
    report->state = device::DeviceState::LOST;
    report->message = "unplugged";
    log->refuseSends = true;
    const auto gone = pipeline.attend();
    ASSERT_NE(gone, nullptr);
    EXPECT_FALSE(gone->playing);
    ASSERT_EQ(gone->messages.size(), 1u);
    EXPECT_EQ(gone->messages[0], "device: lost: unplugged");
    EXPECT_EQ(pipeline.attend(), nullptr) << "said once";
    // As the engine does, which tries again now and then.
    const auto refused = pipeline.process(squareSnapshot());
    EXPECT_FALSE(refused->playing);
    EXPECT_EQ(refused->messages.size(), 1u) << refused->messages.back();
    report->state = device::DeviceState::READY;
    log->refuseSends = false;
    const int sends = log->sends;
    const auto back = pipeline.attend();
    ASSERT_NE(back, nullptr);
    EXPECT_TRUE(back->playing);
    EXPECT_TRUE(sounds(*back));
    EXPECT_EQ(log->sends, sends + 1);
}

TEST_F(LostField, OneLossIsToldOnceHoweverManyFieldsItCosts)
{
    pipeline.process(squareSnapshot());
    for (unsigned int loss = 1; loss <= 2; ++loss)
    {
        report->state = device::DeviceState::LOST;
        log->refuseSends = true;
        for (int k = 1; k <= 20; ++k)
        {
            const auto refused = pipeline.process(squareSnapshot(1e-3 * k));
            ASSERT_EQ(refused->told.size(), 1u);
            EXPECT_EQ(refused->told[0].code, base::MessageCode::DEVICE_LOST);
            EXPECT_EQ(refused->told[0].count, loss);
            EXPECT_EQ(refused->state, ArrayState::LOST);
        }
        report->state = device::DeviceState::READY;
        log->refuseSends = false;
        EXPECT_TRUE(pipeline.process(squareSnapshot())->playing);
    }
}

TEST_F(LostField, OfADriverThatHangsIsAFaultThatIsTold)
{
    pipeline.process(squareSnapshot());
    report->state = device::DeviceState::HANGING;
    report->message = "the driver's play() hasn't returned for 2 s";
    EXPECT_EQ(pipeline.device().reading().state, ArrayState::FAULT) << "before there is a result";
    const auto hangs = pipeline.attend();
    ASSERT_NE(hangs, nullptr);
    EXPECT_EQ(hangs->state, ArrayState::FAULT);
    EXPECT_FALSE(hangs->playing);
    ASSERT_EQ(hangs->told.size(), 1u);
    EXPECT_EQ(hangs->told[0].code, base::MessageCode::DEVICE_HANGS);
    EXPECT_EQ(hangs->told[0].text, "device: hangs: the driver's play() hasn't returned for 2 s");
    pipeline.device().setMuted(true);
    EXPECT_EQ(pipeline.device().reading().state, ArrayState::FAULT) << "it may sound all the same";
    pipeline.device().setMuted(false);
    report->state = device::DeviceState::READY;
    const auto back = pipeline.attend();
    ASSERT_NE(back, nullptr);
    EXPECT_TRUE(back->playing);
    EXPECT_EQ(back->state, ArrayState::PLAYING);
}

TEST_F(LostField, IsNotPressedOnADeviceThatRefuses)
{
    log->refuseSends = true;
    pipeline.process(squareSnapshot());
    EXPECT_EQ(pipeline.attend(), nullptr);
    EXPECT_EQ(log->sends, 1);
}

TEST_F(LostField, OfAMutedDeviceComesBackWhenItIsUnmuted)
{
    report->state = device::DeviceState::MUTED;
    log->refuseSends = true;
    const auto muted = pipeline.process(squareSnapshot());
    EXPECT_EQ(muted->messages.back(), "device: muted");
    EXPECT_EQ(pipeline.attend(), nullptr);
    report->state = device::DeviceState::READY;
    log->refuseSends = false;
    const auto back = pipeline.attend();
    ASSERT_NE(back, nullptr);
    EXPECT_TRUE(back->playing);
}

// The virtual firmware forgets all when it is unplugged; nothing but the hologram thread looks
// after it.
TEST(LostFieldOfAThread, ComesBackWithTheFirmware)
{
    // Away for longer than kAttend_s, so that the thread looks in between.
    HologramThread thread(simulated("sim:?unplug_at=400ms&replug_at=1400ms"));
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    bool played = false;
    bool gone = false;
    bool back = false;
    eventually(
        [&]
        {
            const auto result = thread.latestResult();
            if (result)
            {
                played = played || (result->playing && sounds(*result));
                gone = gone || (played && !result->playing && !sounds(*result));
                back = gone && result->playing && sounds(*result);
            }
            return back;
        });
    EXPECT_TRUE(played);
    EXPECT_TRUE(gone);
    ASSERT_TRUE(back);
    const auto result = thread.latestResult();
    EXPECT_EQ(thread.counters().solves, 1u) << "nothing moved";
    EXPECT_EQ(result->messages, std::vector<std::string>{"device: lost: unplugged"});
    EXPECT_NE(result->deviceStatus.find("1 reconnects"), std::string::npos) << result->deviceStatus;
}

TEST(LostFieldOfAThread, ComesBackAfterDroppedPackets)
{
    // Of the 17 packets of a field one is gone in most cases; what is incomplete is never played.
    HologramThread thread(simulated("sim:?drop=0.1&seed=7"));
    SceneSnapshot snapshot = squareSnapshot();
    thread.submit(snapshot);
    EXPECT_TRUE(eventually(
        [&]
        {
            const auto result = thread.latestResult();
            return result && sounds(*result);
        }));
}
