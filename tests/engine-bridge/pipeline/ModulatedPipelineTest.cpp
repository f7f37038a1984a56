#include "device/limits/GuardedDevice.h"
#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/base/DutyLaw.h"
#include "haptics/base/InputError.h"
#include "tests/Eventually.h"
#include "tests/engine-bridge/pipeline/Fakes.h"

#include <algorithm>
#include <mutex>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

bool waitForSends(const FakeLog& log, int count)
{
    return eventually([&] { return log.sends >= count; });
}

HologramOptions modulated(const std::shared_ptr<FakeLog>& log)
{
    HologramOptions options = fakeOptions(log);
    options.modulation.amplitudeRate_Hz = 100.0;
    return options;
}

} // namespace

TEST(ModulatedPipeline, KeepsSendingBetweenSnapshots)
{
    const auto log = std::make_shared<FakeLog>();
    HologramPipeline pipeline(modulated(log));
    const auto result = pipeline.process(squareSnapshot());
    EXPECT_TRUE(result->playing);
    // The field that is shown is the unmodulated one.
    EXPECT_NEAR(result->played().cwiseAbs().minCoeff(), 1.0f, 1e-6f);
    EXPECT_TRUE(waitForSends(*log, 20));
    pipeline.process(squareSnapshot());
    EXPECT_EQ(log->solves, 1) << "nothing moved";
    EXPECT_TRUE(waitForSends(*log, log->sends + 5));
    pipeline.process(squareSnapshot(0.01));
    EXPECT_EQ(log->solves, 2);
    EXPECT_TRUE(waitForSends(*log, log->sends + 5));
}

TEST(ModulatedPipeline, NothingIsSentOverASilence)
{
    const auto log = std::make_shared<FakeLog>();
    HologramPipeline pipeline(modulated(log));
    pipeline.process(squareSnapshot());
    ASSERT_TRUE(waitForSends(*log, 3));
    pipeline.silence();
    EXPECT_EQ(log->silences, 1);
    const int sent = log->sends;
    EXPECT_TRUE(othersSend(30));
    EXPECT_EQ(log->sends, sent);
    pipeline.process(squareSnapshot());
    EXPECT_TRUE(waitForSends(*log, sent + 3));
    // An empty scene silences as well.
    SceneSnapshot empty;
    pipeline.process(empty);
    const int after = log->sends;
    EXPECT_TRUE(othersSend(30));
    EXPECT_EQ(log->sends, after);
    EXPECT_EQ(log->silences, 2);
}

TEST(ModulatedPipeline, OptionsOutOfRangeAreNamed)
{
    HologramOptions options = fakeOptions(std::make_shared<FakeLog>());
    options.modulation.amplitudeRate_Hz = 1000.0;
    std::string error;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_EQ(error, "amplitudeRate_Hz is 1000; it must be within 0 .. 500");
}

namespace
{

/// Keeps the loudest duty of each field that it is sent.
class PeakDevice : public FakeDevice
{
public:
    using FakeDevice::FakeDevice;

    bool send(const device::DriveSignal& signal) override
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _peaks.push_back(*std::max_element(signal.duty.begin(), signal.duty.end()));
        return true;
    }
    std::vector<int> peaks() const
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return _peaks;
    }

private:
    mutable std::mutex _mutex;
    std::vector<int> _peaks;
};

/// The levels that are sent over some periods of a modulation, with caps of program and device.
std::set<int> levelsSent(double maxAmplitude, double ofDevice)
{
    const auto log = std::make_shared<FakeLog>();
    HologramOptions options = modulated(log);
    options.maxAmplitude = maxAmplitude;
    PeakDevice* peaks = nullptr;
    options.deviceFactory = [&](const std::string&, const device::DeviceLayout& layout)
    {
        auto inner = std::make_unique<PeakDevice>(log, layout.transducers);
        peaks = inner.get();
        device::SafetyLimits limits;
        limits.maxAmplitude = ofDevice;
        return std::make_unique<device::GuardedDevice>(
            std::move(inner), limits, layout.transducers);
    };
    HologramPipeline pipeline(options);
    pipeline.process(squareSnapshot());
    EXPECT_TRUE(eventually([&] { return peaks->peaks().size() > 100; }));
    const std::vector<int> sent = peaks->peaks();
    return {sent.begin(), sent.end()};
}

} // namespace

TEST(ModulatedPipeline, ACapOfTheAmplitudeLeavesTheFormOfAModulation)
{
    const std::set<int> whole = levelsSent(1.0, 1.0);
    ASSERT_GT(whole.size(), 4U);
    for (const auto& [program, ofDevice] : {std::pair(0.5, 1.0), std::pair(1.0, 0.5)})
    {
        const std::set<int> capped = levelsSent(program, ofDevice);
        ASSERT_EQ(capped.size(), whole.size()) << "no top is cut off";
        auto one = whole.begin();
        for (const int level : capped)
            EXPECT_NEAR(base::dutyAmplitude(level), 0.5 * base::dutyAmplitude(*one++), 0.01);
    }
}
