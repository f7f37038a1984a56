#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/Eventually.h"
#include "tests/engine-bridge/pipeline/DoubleField.h"
#include "tests/engine-bridge/pipeline/Fakes.h"

#include <chrono>

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

/// A SonicSurface, whose transducers are on or off, with a cap of its own.
HologramOptions sonicOptions(double max_Pa)
{
    HologramOptions options = cappedOptions(max_Pa, "sim:?board=sonicsurface");
    options.array = haptics::TransducerArray::load("sonicsurface");
    return options;
}

/// A square \a height_m above the middle of \a board.
SceneSnapshot squareAbove(const haptics::TransducerArray& board, double height_m = 0.12)
{
    SceneSnapshot snapshot = squareSnapshot();
    snapshot.objects[0].pose.translation() =
        board.positions.rowwise().mean() + height_m * board.normals.col(0);
    return snapshot;
}

/// Silence under a cap, and no figure that says anything else.
void expectSilenced(const HologramResult& result)
{
    ASSERT_GT(result.points.size(), 0);
    EXPECT_TRUE(result.isSilenced());
    EXPECT_STREQ(haptics::stopReasonName(result.report().stop), "silenced");
    EXPECT_EQ(result.report().capFactor, 0.0);
    EXPECT_EQ(result.report().rms, 1.0);
    EXPECT_EQ(result.report().max, 1.0);
    EXPECT_EQ(result.report().level_Pa, 0.0);
    EXPECT_EQ(result.report().loudness, 0.0);
    EXPECT_EQ(result.played().cwiseAbs().maxCoeff(), 0.0f);
    EXPECT_EQ(result.achieved_Pa.maxCoeff(), 0.0f);
    EXPECT_EQ(result.fingertip.force_N, 0.0);
}

/// The pressure that a message of silence names.
double leastCap_Pa(const std::string& message)
{
    const std::string before = "gives up to ";
    const std::size_t at = message.find(before);
    return at == std::string::npos ? 0.0 : std::stod(message.substr(at + before.size()));
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
    const double share = result->report().level_Pa / loud->report().level_Pa;
    EXPECT_GT(loud->fingertip.force_N, 0.0);
    EXPECT_NEAR(result->fingertip.force_N,
                share * share * loud->fingertip.force_N,
                0.02 * loud->fingertip.force_N)
        << "of what is played, caps included";
    EXPECT_LT(result->report().rms, 0.01) << "the shape is kept";
    EXPECT_EQ(result->counters.capped, 1u);
    EXPECT_FALSE(result->isSilenced());
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

// Which cap, by which setting, and what asks for too much.
TEST(CappedPipeline, NamesTheCapAndWhatAsksForTooMuch)
{
    const auto told = [](const HologramOptions& options, const SceneSnapshot& snapshot)
    {
        HologramPipeline pipeline(options);
        const auto result = pipeline.process(snapshot);
        for (const base::Message& one : result->told)
            if (one.code == base::MessageCode::CAP_PRESSURE ||
                one.code == base::MessageCode::CAP_EARS)
                return one.text;
        return std::string();
    };
    SceneSnapshot two = squareOf(1500.0);
    two.objects.push_back(squareSnapshot(0.08).objects[0]);
    two.objects[1].id = 2;
    two.objects[1].path = "Scene/Meek";
    two.objects[1].properties = two.objects[0].properties;
    two.objects[1].properties.pressure = 450.0;
    EXPECT_EQ(told(cappedOptions(400.0), two),
              "the field is held down to the cap of 400 Pa at any control point, by MaxPressure: "
              "Scene/Square wants 1.5 kPa, by its pressure");
    EXPECT_EQ(told(cappedOptions(0.0, "sim:?max-pressure=350"), squareOf(800.0)),
              "the field is held down to the cap of 350 Pa at any control point, by max-pressure "
              "of the device: Scene/Square wants 800 Pa, by its pressure");
    HologramOptions eared = cappedOptions(1e6);
    eared.earLimit = 125.0;
    EXPECT_EQ(told(eared, squareOf(3000.0)),
              "the field is held down to the ear limit of 125 dB: Scene/Square wants 3 kPa, by "
              "its pressure");
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
    HologramPipeline pipeline(sonicOptions(20.0));
    const SceneSnapshot snapshot = squareAbove(pipeline.options().array);
    const auto result = pipeline.process(snapshot);
    expectSilenced(*result);
    EXPECT_TRUE(result->playing) << "nothing is what is to be played";
    ASSERT_EQ(result->messages.size(), 1u);
    EXPECT_EQ(result->messages.back(), result->report().message);
    EXPECT_EQ(
        result->messages.back().rfind(
            "silent: the array's levels are too coarse for the cap of 20 Pa at any control point; "
            "one transducer alone at its lowest level, 1 of full drive, gives up to ",
            0),
        0u)
        << result->messages.back();
    EXPECT_EQ(pipeline.process(snapshot), result) << "and not solved again and again";
    // What moves is silenced again, for another pressure; that is told once.
    const auto next = pipeline.process(squareAbove(pipeline.options().array, 0.13));
    expectSilenced(*next);
    EXPECT_NE(next->report().message, result->report().message);
    EXPECT_EQ(next->messages.size(), 1u);
}

TEST(CappedPipeline, ACapAboveThePressureThatIsToldPlays)
{
    HologramPipeline silent(sonicOptions(20.0));
    const std::string told = silent.process(squareAbove(silent.options().array))->report().message;
    const double least_Pa = leastCap_Pa(told);
    ASSERT_GT(least_Pa, 20.0) << told;
    EXPECT_NE(told.find("raise MaxPressure above that"), std::string::npos) << told;
    for (const double share : {0.9, 1.01})
    {
        HologramPipeline pipeline(sonicOptions(share * least_Pa));
        const auto result = pipeline.process(squareAbove(pipeline.options().array));
        if (share < 1.0)
            expectSilenced(*result);
        else
        {
            EXPECT_NE(result->report().stop, haptics::StopReason::SILENCED);
            EXPECT_GT(result->report().level_Pa, 0.0);
        }
    }
}

TEST(CappedPipeline, ACapOfTheDeviceIsToldAsTheDevices)
{
    HologramOptions options = sonicOptions(0.0);
    options.deviceUri += "&max-pressure=20";
    HologramPipeline pipeline(options);
    const auto result = pipeline.process(squareAbove(options.array));
    expectSilenced(*result);
    EXPECT_NE(result->report().message.find("raise max-pressure of the device above that"),
              std::string::npos)
        << result->report().message;
}

TEST(CappedPipeline, SeveralFieldsInTurnAreSilencedAlike)
{
    HologramOptions options = sonicOptions(20.0);
    options.subsets = 3;
    HologramPipeline pipeline(options);
    expectSilenced(*pipeline.process(squareAbove(options.array)));
}

TEST(CappedPipeline, AFieldBelowTheLowestLevelIsSilencedWithoutACap)
{
    const auto log = std::make_shared<FakeLog>();
    HologramOptions options = fakeOptions(log);
    options.deviceFactory = nullptr;
    log->amplitude = 1e-4f; // a level of duty is 6e-3
    HologramPipeline pipeline(options);
    const auto result = pipeline.process(squareSnapshot());
    EXPECT_EQ(result->report().stop, haptics::StopReason::SILENCED);
    EXPECT_EQ(result->report().rms, 1.0);
    EXPECT_EQ(result->report().level_Pa, 0.0);
    EXPECT_EQ(result->achieved_Pa.maxCoeff(), 0.0f);
    EXPECT_NE(result->report().message.find("is weaker than the array's lowest level"),
              std::string::npos)
        << result->report().message;
    ASSERT_FALSE(result->messages.empty());
    EXPECT_EQ(result->messages.back(), result->report().message);
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
    EXPECT_TRUE(eventually([&] { return log->sends >= 40; }));
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
    EXPECT_GT(result->report().level_Pa, 50.0); // the fake solver's field is far from even
    EXPECT_LE(result->report().level_Pa, 250.0);
}

TEST(CappedPipeline, AnOptionOutOfRangeIsNamed)
{
    HologramOptions options = cappedOptions(-5.0);
    std::string error;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_EQ(error, "maxPressure is -5 Pa; it must be within 0 .. 1e+06");
}

TEST(CappedPipeline, WhatIsWeakerThanTheLeastOfTheArrayIsAFaultAndSilent)
{
    for (const bool isLoudness : {true, false})
    {
        HologramOptions options = cappedOptions(0.0);
        if (isLoudness) options.solverOptions.loudness = 1e-6;
        HologramPipeline pipeline(options);
        const auto result = pipeline.process(isLoudness ? squareSnapshot() : squareOf(1e-6));
        EXPECT_TRUE(result->isSilenced());
        EXPECT_EQ(result->state, ArrayState::SILENT);
        EXPECT_EQ(pipeline.device().reading().state, ArrayState::SILENT);
        ASSERT_EQ(result->told.size(), 1u);
        EXPECT_EQ(result->told[0].code, base::MessageCode::FIELD_SILENCED);
    }
}

TEST(CappedPipeline, AFieldThatIsStillRisingPlaysAndIsMeasuredAgain)
{
    HologramPipeline pipeline(cappedOptions(0.0, "sim:?ramp=50ms"));
    const auto first = pipeline.process(squareSnapshot());
    EXPECT_EQ(first->state, ArrayState::PLAYING);
    double last_Pa = first->achieved_Pa.minCoeff();
    EXPECT_TRUE(eventually(
        [&]
        {
            if (const auto later = pipeline.attend()) last_Pa = later->achieved_Pa.minCoeff();
            return last_Pa >= 0.9 * first->report().level_Pa;
        }));
}
