#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/base/InputError.h"
#include "tests/Eventually.h"
#include "tests/engine-bridge/pipeline/Fakes.h"

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
