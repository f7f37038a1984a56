#include "haptics/sequence/SpeckleCycle.h"

#include "haptics/base/InputError.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <Eigen/Geometry>

#include <cmath>

#include <gtest/gtest.h>

namespace midair::haptics
{
namespace
{

// The same sphere, turned as a whole for each set, so that every set fills the gaps of the others.
std::vector<ControlPoints> turnedSpheres(int count, int n, double radius_m)
{
    std::vector<ControlPoints> sets;
    for (int k = 0; k < count; ++k)
    {
        ControlPoints points = spherePoints(n, radius_m);
        const Eigen::Matrix3d turn =
            (Eigen::AngleAxisd(0.7 * k, Eigen::Vector3d::UnitY()) *
             Eigen::AngleAxisd(1.1 * k, Eigen::Vector3d(1, 0, 1).normalized()))
                .toRotationMatrix();
        points.positions = turn * points.positions;
        sets.push_back(points);
    }
    return sets;
}

TEST(SpeckleCycle, FieldsInTurnSmoothTheSphere)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const Eigen::Matrix3Xd surface = spherePoints(2000, 0.03).positions;
    SpeckleCycle cycle;
    const SpeckleCycleReport eight =
        cycle.solve(turnedSpheres(8, 100, 0.03), surface, array, Medium());
    EXPECT_EQ(eight.points, 800);
    EXPECT_LE(eight.cycle.coefficientOfVariation, 0.35); // asked for
    EXPECT_GT(eight.alone.coefficientOfVariation, 0.8);  // speckle has about 1
    // No loss but what one field's mean differs from another's.
    EXPECT_GT(eight.cycle.mean_Pa, 0.97 * eight.alone.mean_Pa);
    EXPECT_LT(eight.worstRms, 0.005);
    const SpeckleCycleReport sixteen =
        cycle.solve(turnedSpheres(16, 100, 0.03), surface, array, Medium());
    EXPECT_LE(sixteen.cycle.coefficientOfVariation, 0.25); // asked for
    EXPECT_GT(sixteen.cycle.mean_Pa, 0.97 * sixteen.alone.mean_Pa);
}

TEST(SpeckleCycle, EveningOutTogetherSmoothsFurther)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const Eigen::Matrix3Xd surface = spherePoints(300, 0.012).positions; // 2.5 mm apart
    const std::vector<ControlPoints> sets = turnedSpheres(2, 16, 0.012);
    SpeckleCycleOptions options;
    SpeckleCycle apart(options);
    options.sweeps = 6;
    SpeckleCycle together(options);
    const SpeckleCycleReport a = apart.solve(sets, surface, array, Medium());
    const SpeckleCycleReport b = together.solve(sets, surface, array, Medium());
    // Measured at places between those that were evened out.
    const Eigen::Matrix3Xd other = spherePoints(1111, 0.012).positions;
    const auto on = [&](const SpeckleCycle& cycle)
    { return surfaceStatistics(other, array, Medium(), cycle.fields()); };
    EXPECT_LT(on(together).coefficientOfVariation, 0.6 * on(apart).coefficientOfVariation);
    EXPECT_GT(on(together).mean_Pa, 0.95 * a.alone.mean_Pa);
    EXPECT_NEAR(on(together).coefficientOfVariation, b.cycle.coefficientOfVariation, 0.05);
}

TEST(SpeckleCycle, ASetWithoutPointsStaysSilentWhileTheOthersAreEvenedOut)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const Eigen::Matrix3Xd surface = spherePoints(300, 0.012).positions;
    SpeckleCycleOptions options;
    options.sweeps = 1;
    std::vector<ControlPoints> sets = turnedSpheres(2, 16, 0.012);
    sets.insert(sets.begin(), ControlPoints());
    SpeckleCycle cycle(options);
    const SpeckleCycleReport report = cycle.solve(sets, surface, array, Medium());
    EXPECT_GT(report.alone.mean_Pa, 0.0);
    EXPECT_TRUE(std::isfinite(report.cycle.coefficientOfVariation));
    for (std::size_t k = 0; k < sets.size(); ++k)
    {
        ASSERT_TRUE(cycle.fields()[k].allFinite());
        EXPECT_EQ(cycle.fields()[k].isZero(0.0f),
                  sets[static_cast<std::size_t>(cycle.order()[k])].size() == 0);
    }
    const SpeckleCycleReport none =
        cycle.solve({ControlPoints(), ControlPoints()}, surface, array, Medium());
    EXPECT_EQ(none.cycle.mean_Pa, 0.0);
    for (const Eigen::VectorXcf& q : cycle.fields())
        EXPECT_TRUE(q.isZero(0.0f));
}

// Each field turned by a phase of its own, in a shuffled order: what the cycle makes of it is not worse than the best
// order of all, by trying them.
TEST(SpeckleCycle, OrdersAndAlignsForTheLeastChange)
{
    const TransducerArray array = TransducerArray::singleBoard();
    std::vector<ControlPoints> sets;
    for (const int place : {0, 3, 1, 4, 2})
    {
        ControlPoints points;
        points.positions.resize(3, 1);
        points.positions << 0.004 * place, 0.0, 0.1;
        points.normals.resize(3, 1);
        points.normals << 0, 0, 1;
        points.targets = Eigen::VectorXd::Ones(1);
        sets.push_back(points);
    }
    SpeckleCycle ordered;
    ordered.solve(sets, {}, array, Medium());
    SpeckleCycleOptions options;
    options.reorder = false;
    SpeckleCycle asGiven(options);
    asGiven.solve(sets, {}, array, Medium());
    EXPECT_LT(ordered.report().driveChange, asGiven.report().driveChange);
    // No common phase of any field lowers the change of the aligned cycle by more than a level's rounding.
    std::vector<Eigen::VectorXcf> turned = ordered.fields();
    for (std::size_t k = 0; k < turned.size(); ++k)
        for (const float angle : {0.2f, -0.2f})
        {
            turned[k] = ordered.fields()[k] * std::polar(1.0f, angle);
            EXPECT_GT(cycleSteps(turned).driveChange, ordered.report().driveChange);
            turned[k] = ordered.fields()[k];
        }
}

TEST(SpeckleCycle, StepsBetweenFieldsTurnTheShorterWayAndStayPlayable)
{
    const TransducerArray array = TransducerArray::singleBoard();
    SpeckleCycle cycle;
    std::vector<ControlPoints> sets(3);
    for (int k = 0; k < 3; ++k)
    {
        sets[static_cast<std::size_t>(k)] = spherePoints(4, 0.01, {0.01 * k, 0, 0.1});
    }
    cycle.solve(sets, {}, array, Medium());
    const CycleSteps plain = cycleSteps(cycle.fields());
    const std::vector<Eigen::VectorXcf> smooth = cycle.smoothed(3);
    ASSERT_EQ(smooth.size(), 12u);
    EXPECT_EQ(smooth[4], cycle.fields()[1]);
    const CycleSteps steps = cycleSteps(smooth);
    EXPECT_NEAR(steps.meanPhaseStep_rad, plain.meanPhaseStep_rad / 4, 0.01); // 8-bit levels
    EXPECT_LT(steps.largestPhaseStep_rad, M_PI / 4 + 2 * M_PI / 256);
    EXPECT_LT(steps.driveChange, plain.driveChange / 8);
    for (const Eigen::VectorXcf& q : smooth)
        for (const std::complex<float>& value : q)
        {
            const double level = std::arg(value) * 256.0 / (2.0 * M_PI);
            EXPECT_NEAR(level, std::round(level), 1e-3);
        }
    EXPECT_EQ(cycle.smoothed(0).size(), 3u);
    EXPECT_THROW(cycle.smoothed(-1), base::InputError);
}

TEST(SpeckleCycle, SaysWhatIsWrong)
{
    SpeckleCycle cycle;
    const auto failing = [&](const std::vector<ControlPoints>& sets)
    {
        try
        {
            cycle.solve(sets, {}, TransducerArray::singleBoard(), Medium());
        }
        catch (const base::InputError& error)
        {
            return std::string(error.what());
        }
        return std::string("no error");
    };
    EXPECT_EQ(failing({}), "field cycle: there are no sets of points; there must be at least one");
    std::vector<ControlPoints> sets(2, spherePoints(2, 0.01, {0, 0, 0.1}));
    sets[1].positions(0, 1) = std::nan("");
    EXPECT_EQ(failing(sets).substr(0, 22), "field cycle: set 1: co");
    SpeckleCycleOptions options;
    options.sweeps = -1;
    std::string error;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_EQ(error, "sweeps is -1; it must be at least 0");
    options.solver = "unheard-of";
    options.sweeps = 0;
    SpeckleCycle unknown(options);
    EXPECT_THROW(unknown.solve({spherePoints(2, 0.01)}, {}, TransducerArray::singleBoard(), {}),
                 base::InputError);
}

} // namespace
} // namespace midair::haptics
