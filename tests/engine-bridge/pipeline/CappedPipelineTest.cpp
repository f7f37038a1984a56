#include "engine-bridge/pipeline/HologramPipeline.h"
#include "tests/engine-bridge/pipeline/DoubleField.h"
#include "tests/engine-bridge/pipeline/Fakes.h"

#include <thread>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

HologramOptions cappedOptions(double max_Pa, const std::string& uri = "sim:")
{
    HologramOptions options;
    options.array = haptics::TransducerArray::octagonalPrism();
    options.maxPressure = max_Pa;
    options.deviceUri = uri;
    return options;
}

SceneSnapshot squareOf(double pressure_Pa)
{
    SceneSnapshot snapshot = squareSnapshot();
    snapshot.objects[0].properties.pressure = pressure_Pa;
    snapshot.objects[0].properties.pressureInPa = true;
    return snapshot;
}

double loudestOf(const HologramPipeline& pipeline, const HologramResult& result)
{
    return loudestInDouble(result.points.positions,
                           pipeline.options().array,
                           pipeline.options().medium,
                           result.played());
}

} // namespace

TEST(CappedPipeline, ARelativeFieldIsScaledDownAsAWhole)
{
    HologramPipeline free(cappedOptions(0.0));
    const auto loud = free.process(squareSnapshot());
    EXPECT_EQ(loud->report().capFactor, 1.0);
    EXPECT_EQ(loud->maxPressure_Pa, 0.0);
    const double cap_Pa = loud->report().level_Pa / 3.0;
    HologramPipeline pipeline(cappedOptions(cap_Pa));
    const auto result = pipeline.process(squareSnapshot());
    const double loudest_Pa = loudestOf(pipeline, *result);
    EXPECT_LE(loudest_Pa, cap_Pa);
    EXPECT_GT(loudest_Pa, 0.97 * cap_Pa);
    EXPECT_EQ(result->maxPressure_Pa, cap_Pa);
    EXPECT_NEAR(result->report().capFactor, 1.0 / 3.0, 0.02);
    EXPECT_NEAR(result->report().level_Pa,
                loud->report().level_Pa * result->report().capFactor,
                0.01 * cap_Pa);
    EXPECT_LT(result->report().rms, 0.01) << "the shape is kept";
    EXPECT_EQ(result->counters.capped, 1u);
    ASSERT_EQ(result->messages.size(), 1u);
    EXPECT_EQ(result->messages[0].rfind("the field is held down to the cap of ", 0), 0u)
        << result->messages[0];
    EXPECT_TRUE(result->playing);
}

TEST(CappedPipeline, AbsoluteTargetsOverTheCapDontGetThere)
{
    HologramPipeline pipeline(cappedOptions(400.0));
    const auto quiet = pipeline.process(squareOf(300.0));
    EXPECT_EQ(quiet->report().capFactor, 1.0) << "what keeps to the cap is as it was";
    EXPECT_NEAR(quiet->report().level_Pa, 300.0, 10.0);
    const auto result = pipeline.process(squareOf(1500.0));
    EXPECT_LE(loudestOf(pipeline, *result), 400.0);
    EXPECT_GT(loudestOf(pipeline, *result), 360.0); // a level is 8 % there
    EXPECT_LT(result->report().capFactor, 0.4);
    EXPECT_EQ(result->report().shortPoints, result->points.size());
    EXPECT_NEAR(result->report().worstShortfall, 1.0 - 400.0 / 1500.0, 0.03);
}

TEST(CappedPipeline, TheStricterCapCounts)
{
    const auto capOf = [](double options_Pa, const std::string& uri)
    {
        HologramPipeline pipeline(cappedOptions(options_Pa, uri));
        const auto result = pipeline.process(squareSnapshot());
        EXPECT_LE(loudestOf(pipeline, *result), result->maxPressure_Pa);
        return result->maxPressure_Pa;
    };
    EXPECT_EQ(capOf(0.0, "sim:?max-pressure=350"), 350.0);
    EXPECT_EQ(capOf(200.0, "sim:?max-pressure=350"), 200.0);
    EXPECT_EQ(capOf(500.0, "sim:?max-pressure=350"), 350.0);
    EXPECT_EQ(capOf(500.0, "sim:?boards=0-7&max-pressure=450,sim:?boards=8-15"), 450.0);
    EXPECT_EQ(capOf(300.0, "null:?max-amplitude=0.5"), 300.0);
}

TEST(CappedPipeline, ASolverThatKnowsNoLimitsIsHeldToo)
{
    // All transducers full on, whatever is asked for.
    auto options = fakeOptions(std::make_shared<FakeLog>());
    options.deviceFactory = nullptr;
    options.maxPressure = 250.0;
    HologramPipeline pipeline(options);
    const auto result = pipeline.process(squareSnapshot());
    EXPECT_LE(loudestOf(pipeline, *result), 250.0);
    EXPECT_GT(loudestOf(pipeline, *result), 240.0);
}

TEST(CappedPipeline, SilentWhereTheLevelsCantKeepToTheCap)
{
    HologramOptions options = cappedOptions(20.0, "sim:?board=sonicsurface");
    options.array = haptics::TransducerArray::load("sonicsurface");
    HologramPipeline pipeline(options);
    SceneSnapshot snapshot = squareSnapshot();
    snapshot.objects[0].pose.translation() =
        options.array.positions.rowwise().mean() + 0.12 * options.array.normals.col(0);
    const auto result = pipeline.process(snapshot);
    ASSERT_GT(result->points.size(), 0);
    EXPECT_EQ(result->report().capFactor, 0.0);
    EXPECT_EQ(result->played().cwiseAbs().maxCoeff(), 0.0f);
    EXPECT_EQ(result->achieved_Pa.maxCoeff(), 0.0f);
    ASSERT_FALSE(result->messages.empty());
    EXPECT_EQ(result->messages.back(),
              "silent: the device's levels can't keep to the cap of 20 Pa at any control point");
    EXPECT_EQ(pipeline.process(snapshot), result) << "and not solved again and again";
}

TEST(CappedPipeline, TheModulatedFieldIsHeldDownToo)
{
    const auto log = std::make_shared<FakeLog>();
    HologramOptions options = fakeOptions(log);
    options.maxPressure = 250.0;
    options.modulation.amplitudeRate_Hz = 100.0;
    HologramPipeline pipeline(options);
    const auto result = pipeline.process(squareSnapshot());
    EXPECT_LE(loudestOf(pipeline, *result), 250.0);
    for (int i = 0; i < 10000 && log->sends < 40; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_GE(log->sends, 40);
    EXPECT_LE(log->loudestAmplitude, result->played().cwiseAbs().maxCoeff() + 1e-6f);
}

TEST(CappedPipeline, AFieldThatWaitsForItsDeviceIsRatedAsItWillBePlayed)
{
    const auto log = std::make_shared<FakeLog>();
    HologramOptions options = fakeOptions(log);
    options.maxPressure = 250.0;
    log->refuseSends = true;
    HologramPipeline pipeline(options);
    const auto result = pipeline.process(squareSnapshot());
    EXPECT_FALSE(result->playing);
    EXPECT_EQ(result->achieved_Pa.maxCoeff(), 0.0f);
    EXPECT_GT(result->report().level_Pa, 100.0);
    EXPECT_LE(result->report().level_Pa, 250.0);
}

TEST(CappedPipeline, AnOptionOutOfRangeIsNamed)
{
    HologramOptions options = cappedOptions(-5.0);
    std::string error;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_EQ(error, "maxPressure is -5; it must be within 0 .. 1e+06");
}
