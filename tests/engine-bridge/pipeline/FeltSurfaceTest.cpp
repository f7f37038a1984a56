#include "engine-bridge/pipeline/SampleCache.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/sequence/CycleEqualizer.h"
#include "tests/engine-bridge/pipeline/Fakes.h"

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

constexpr double kWave_m = 8.58e-3;

/// Two points of the first object, 10 mm apart, and one of the second.
haptics::ControlPoints points()
{
    haptics::ControlPoints points;
    points.positions.resize(3, 3);
    points.positions << -0.005, 0.005, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0;
    points.targets = Eigen::Vector3d(1.0, 0.5, 0.25);
    points.object = {0, 0, 1};
    return points;
}

std::vector<HapticObject> objects()
{
    std::vector<HapticObject> both = squareSnapshot().objects;
    both.push_back(both.front());
    both[1].id = 2;
    both[1].pose.translation().x() = 0.1;
    return both;
}

} // namespace

TEST(FeltSurface, ItsPlacesAreNearTheOwnPointsOfEachObject)
{
    const auto places = FeltSurface(kWave_m).places(objects(), points(), 8);
    ASSERT_TRUE(places);
    const double reach_m = haptics::kFeltReach * kWave_m;
    int of[3] = {0, 0, 0};
    for (int l = 0; l < places->places.size(); ++l)
    {
        const Eigen::Vector3d place = places->places.positions.col(l);
        Eigen::Index nearest = 0;
        const double distance =
            (points().positions.colwise() - place).colwise().norm().minCoeff(&nearest);
        EXPECT_LE(distance, reach_m);
        EXPECT_EQ(places->places.targets[l], points().targets[nearest]);
        ++of[nearest];
    }
    // A disc of that reach each, two of them overlapping, sampled at 0.22 wavelengths.
    EXPECT_GT(of[2], 40);
    EXPECT_GT(of[0] + of[1], of[2]);
    EXPECT_NEAR(of[0], of[1], 12);
}

// Evened out at the former, a field is measured at the latter.
TEST(FeltSurface, OfAHeldFieldThereArePlacesBetweenToo)
{
    const auto found = FeltSurface(kWave_m).places(objects(), points(), 1);
    ASSERT_TRUE(found);
    EXPECT_EQ(FeltSurface(kWave_m).places(objects(), points(), 8)->between.cols(), 0);
    EXPECT_EQ(found->between.cols(), found->places.size()) << "of few all";
    double sum_m = 0.0;
    for (const auto& place : found->between.colwise())
    {
        EXPECT_LE((points().positions.colwise() - place).colwise().norm().minCoeff(),
                  haptics::kFeltReach * kWave_m);
        sum_m += (found->places.positions.colwise() - place).colwise().norm().minCoeff();
    }
    EXPECT_GT(sum_m / static_cast<double>(found->between.cols()),
              0.5 * haptics::kClosePlaceSpacing * kWave_m);
}

TEST(FeltSurface, LargeSurfacesAreSampledMoreCoarselyOrNotAtAll)
{
    std::vector<HapticObject> one(1, objects().front());
    haptics::ControlPoints all;
    all.positions = Eigen::Matrix3Xd::Zero(3, 1);
    all.targets = Eigen::VectorXd::Ones(1);
    all.object = {0};
    int before = 0;
    bool isTold = false;
    for (const double size_m : {0.1, 0.14, 0.16, 0.18, 0.5})
    {
        one.front().mesh = squareMesh(size_m);
        one.front().meshId = static_cast<std::uint64_t>(1e3 * size_m);
        one.front().properties.spacing_m = size_m; // all is within reach of the one point
        const auto places = FeltSurface(kWave_m).places(one, all, 8);
        isTold = !places;
        if (!places) break;
        EXPECT_LE(places->places.size(), haptics::kMostPlaces);
        EXPECT_GT(places->places.size(), 1000);
        before = std::max(before, places->places.size());
    }
    EXPECT_TRUE(isTold);
    EXPECT_GT(before, 3000);
}

TEST(FeltSurface, AStopIsThrown)
{
    base::StopSource source;
    FeltSurface surface(kWave_m);
    surface.setStop(source.token());
    source.request();
    EXPECT_THROW(surface.places(objects(), points(), 8), base::Stopped);
    source.clear();
    EXPECT_TRUE(surface.places(objects(), points(), 8));
}
