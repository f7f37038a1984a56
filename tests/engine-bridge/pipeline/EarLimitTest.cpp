#include "engine-bridge/pipeline/HologramPipeline.h"
#include "engine-bridge/playing/EarBound.h"
#include "tests/engine-bridge/pipeline/DoubleField.h"
#include "tests/engine-bridge/pipeline/Fakes.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

/// Places at the open end of the prism, where no board is in between.
Eigen::Matrix3Xd atOpenEnd()
{
    Eigen::Matrix3Xd places(3, 4);
    places << 0.0, 0.05, -0.08, 0.02, 0.5, 0.6, 0.55, 0.9, 0.0, 0.03, 0.05, -0.1;
    return places;
}

HologramOptions eared(double limit_dB)
{
    HologramOptions options;
    options.array = haptics::TransducerArray::octagonalPrism();
    options.earLimit = limit_dB;
    options.earPoints = atOpenEnd();
    return options;
}

/// The loudest of the fields at the given places, dB, by brute force.
double loudest_dB(const HologramResult& result)
{
    double most_Pa = 0.0;
    for (const Eigen::VectorXcf& q : result.sequence.fields)
        most_Pa = std::max(most_Pa, loudestInDouble(atOpenEnd(), *result.array, result.medium, q));
    most_Pa *= earFactor(*result.array, 10.1); // the octagon's own P0 is its focus's
    return haptics::soundLevel_dB(0.5 * most_Pa * most_Pa);
}

} // namespace

TEST(EarLimit, WithoutOneTheLevelIsTold)
{
    HologramPipeline pipeline(eared(0.0));
    const auto result = pipeline.process(squareSnapshot());
    EXPECT_EQ(result->report().capFactor, 1.0);
    EXPECT_EQ(result->exposure.places, EarWatch::kAround + 4);
    EXPECT_EQ(result->exposure.limit_dB, 0.0);
    EXPECT_GT(result->exposure.level_dB, 120.0);
    EXPECT_GE(result->exposure.level_dB, loudest_dB(*result) - 0.01);
    EXPECT_TRUE(result->messages.empty());
    pipeline.process(SceneSnapshot());
    EXPECT_EQ(pipeline.exposure().level_dB, 0.0);
    EXPECT_GE(pipeline.exposure().time_s, 0.0);
}

TEST(EarLimit, HoldsForEveryFieldHoweverItIsMade)
{
    struct Case
    {
        const char* name;
        int cycle = 1;
        int subsets = 1;
        bool phaseOnly = true;
        double loudness = 1.0;
        double modulation_Hz = 0.0;
    };
    const Case cases[] = {{"held"},
                          {"cycle", 4},
                          {"subsets", 1, 3},
                          {"amplitudes", 1, 1, false},
                          {"loud", 1, 1, true, 1.6},
                          {"quiet", 1, 1, true, 0.4},
                          {"modulated", 2, 1, true, 1.0, 150.0}};
    for (const Case& one : cases)
    {
        HologramOptions options = eared(0.0);
        options.cycle = one.cycle;
        options.subsets = one.subsets;
        options.solverOptions.phaseOnly = one.phaseOnly;
        options.solverOptions.loudness = one.loudness;
        options.modulation.amplitudeRate_Hz = one.modulation_Hz;
        HologramPipeline free(options);
        const double before_dB = loudest_dB(*free.process(squareSnapshot()));
        options.earLimit = 130.0;
        HologramPipeline pipeline(options);
        auto result = pipeline.process(squareSnapshot());
        EXPECT_GT(before_dB, 130.0) << one.name << ": or this shows nothing";
        for (int k = 0; k < 200; ++k)
        {
            EXPECT_LE(loudest_dB(*result), 130.0) << one.name;
            EXPECT_GT(result->played().norm(), 0.0f) << one.name;
            EXPECT_LT(result->report().capFactor, 1.0) << one.name;
            if (pipeline.rest_s() > 0.0) break;
            if (auto next = pipeline.attend()) result = next;
        }
        EXPECT_LE(result->exposure.level_dB, 130.0) << one.name;
        ASSERT_FALSE(result->messages.empty()) << one.name;
        EXPECT_EQ(result->messages[0], "the field is held down to the ear limit of 130 dB");
    }
}

TEST(EarLimit, BesideAPressureCapTheStricterCounts)
{
    HologramOptions options = eared(133.0);
    options.maxPressure = 1e6;
    HologramPipeline ears(options);
    const auto held = ears.process(squareSnapshot());
    ASSERT_FALSE(held->messages.empty());
    EXPECT_EQ(held->messages[0], "the field is held down to the ear limit of 133 dB");
    options.maxPressure = 100.0;
    HologramPipeline both(options);
    const auto lower = both.process(squareSnapshot());
    ASSERT_FALSE(lower->messages.empty());
    EXPECT_EQ(lower->messages[0].rfind("the field is held down to the cap of 100 Pa", 0), 0u)
        << lower->messages[0];
    EXPECT_LT(lower->report().capFactor, held->report().capFactor);
    EXPECT_LE(loudest_dB(*lower), 133.0);
}

TEST(EarLimit, AChangeActsWithTheNextField)
{
    const auto log = std::make_shared<FakeLog>();
    HologramOptions options = fakeOptions(log);
    options.solverFactory = {};
    options.earPoints = atOpenEnd();
    const auto limited = [&](double limit_dB)
    {
        HologramOptions other = options;
        other.earLimit = limit_dB;
        return other;
    };
    HologramPipeline pipeline(options);
    EXPECT_GT(loudest_dB(*pipeline.process(squareSnapshot())), 136.0);
    EXPECT_TRUE(pipeline.isStricter(limited(136.0)));
    const int silences = log->silences;
    pipeline.reconfigure(limited(136.0));
    EXPECT_GT(log->silences, silences) << "until there is a field that keeps it";
    const auto first = pipeline.process(squareSnapshot());
    EXPECT_LE(loudest_dB(*first), 136.0);
    EXPECT_GT(first->played().norm(), 0.0f);
    EXPECT_EQ(first->exposure.limit_dB, 136.0);
    EXPECT_TRUE(pipeline.isStricter(limited(128.0)));
    EXPECT_FALSE(pipeline.isStricter(limited(136.0)));
    EXPECT_FALSE(pipeline.isStricter(limited(143.0)));
    EXPECT_TRUE(pipeline.isStricter(limited(std::nan(""))));
    pipeline.reconfigure(limited(128.0));
    EXPECT_LE(loudest_dB(*pipeline.process(squareSnapshot())), 128.0);
    pipeline.reconfigure(options);
    EXPECT_GT(loudest_dB(*pipeline.process(squareSnapshot())), 136.0);
}

TEST(EarLimit, WhatIsNoLimitPlaysNothing)
{
    for (const double wrong : {std::nan(""), -1.0, 5.0, 1e9})
    {
        HologramPipeline pipeline(eared(120.0));
        ASSERT_GT(pipeline.process(squareSnapshot())->played().norm(), 0.0f);
        pipeline.reconfigure(eared(wrong));
        const auto result = pipeline.process(squareSnapshot());
        EXPECT_EQ(result->played().norm(), 0.0f) << wrong;
        EXPECT_NE(result->messages.back().find("earLimit is "), std::string::npos)
            << result->messages.back();
        EXPECT_NE(result->messages.back().find("it must be a number, 0 or 20 .. 200 dB"),
                  std::string::npos)
            << result->messages.back();
        EXPECT_THROW(HologramPipeline again(eared(wrong)), std::exception);
    }
    HologramOptions options = eared(120.0);
    options.earPoints(0, 0) = std::numeric_limits<double>::infinity();
    std::string error;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_EQ(error, "earPoints are not all finite");
}

TEST(EarLimit, ALimitThatNoLevelKeepsSilencesAndSaysWhatWould)
{
    HologramOptions options = eared(40.0);
    options.array = haptics::TransducerArray::load("sonicsurface");
    options.deviceUri = "sim:?board=sonicsurface";
    options.earPoints.resize(3, 0);
    HologramPipeline pipeline(options);
    SceneSnapshot snapshot = squareSnapshot();
    snapshot.objects[0].pose.translation() =
        options.array.positions.rowwise().mean() + 0.12 * options.array.normals.col(0);
    const auto result = pipeline.process(snapshot);
    EXPECT_TRUE(result->isSilenced());
    EXPECT_EQ(result->played().norm(), 0.0f);
    ASSERT_FALSE(result->messages.empty());
    EXPECT_EQ(
        result->messages.back().rfind(
            "silent: the array's levels are too coarse for the ear limit of 40 dB; one transducer "
            "alone at its lowest level, 1 of full drive, gives up to ",
            0),
        0u)
        << result->messages.back();
    const std::string& told = result->messages.back();
    options.earLimit = std::stod(told.substr(told.find("gives up to ") + 12)) + 0.1;
    HologramPipeline louder(options);
    EXPECT_FALSE(louder.process(snapshot)->isSilenced()) << options.earLimit;
}

TEST(EarLimit, FollowsAHeadThatMoves)
{
    HologramPipeline pipeline(eared(133.0));
    SceneSnapshot snapshot = squareSnapshot();
    snapshot.ears = atOpenEnd().leftCols(2) * 2.0;
    const auto far = pipeline.process(snapshot);
    EXPECT_EQ(far->exposure.places, EarWatch::kAround + 6);
    EXPECT_EQ(pipeline.process(snapshot), far);
    snapshot.ears = atOpenEnd().leftCols(2) * 0.6;
    const auto near = pipeline.process(snapshot);
    EXPECT_NE(near, far);
    EXPECT_LT(near->report().capFactor, far->report().capFactor);
    const double most_Pa =
        loudestInDouble(snapshot.ears, *near->array, near->medium, near->played());
    EXPECT_LE(haptics::soundLevel_dB(0.5 * most_Pa * most_Pa), 133.0);
}
