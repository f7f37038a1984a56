#include "haptics/sequence/SequenceComposer.h"

#include "haptics/base/InputError.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/SurfaceStatistics.h"
#include "haptics/sequence/FieldOrder.h"
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

FieldSequence cycleOf(const std::vector<ControlPoints>& sets,
                      const TransducerArray& array,
                      const ComposerOptions& options = {},
                      const ControlPoints& places = {})
{
    base::MessageLog messages;
    return SequenceComposer(options, messages).composeCycle(sets, places, array, Medium());
}

SurfaceStatistics felt(const Eigen::Matrix3Xd& surface,
                       const TransducerArray& array,
                       const std::vector<Eigen::VectorXcf>& fields)
{
    return statisticsOf(meanRadiationPressure(surface, array, Medium(), fields), Eigen::VectorXd());
}

TEST(SequenceComposer, FieldsInTurnSmoothTheSphere)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const Eigen::Matrix3Xd surface = spherePoints(2000, 0.03).positions;
    for (const auto& [count, most] : {std::pair(8, 0.35), std::pair(16, 0.25)}) // asked for
    {
        const FieldSequence cycle = cycleOf(turnedSpheres(count, 100, 0.03), array);
        ASSERT_EQ(cycle.fields.size(), static_cast<std::size_t>(count));
        EXPECT_EQ(cycle.report.points, 100 * count);
        EXPECT_EQ(cycle.points().size(), 100 * count);
        const SurfaceStatistics alone = felt(surface, array, {cycle.fields.front()});
        const SurfaceStatistics all = felt(surface, array, cycle.fields);
        EXPECT_LE(all.coefficientOfVariation, most);
        EXPECT_GT(alone.coefficientOfVariation, 0.8); // speckle has about 1
        // No loss but what one field's mean differs from another's.
        EXPECT_GT(all.mean_Pa, 0.97 * alone.mean_Pa);
        EXPECT_LT(cycle.report.rms, 0.005);
    }
}

TEST(SequenceComposer, EveningOutTogetherSmoothsFurther)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const ControlPoints places = spherePoints(500, 0.012); // 1.9 mm apart
    const std::vector<ControlPoints> sets = turnedSpheres(4, 16, 0.012);
    ComposerOptions options;
    options.even = 0;
    const FieldSequence apart = cycleOf(sets, array, options, places);
    EXPECT_FALSE(apart.evened);
    const FieldSequence together = cycleOf(sets, array, {}, places);
    EXPECT_TRUE(together.evened);
    // Measured at places between those that were evened out.
    const Eigen::Matrix3Xd other = spherePoints(1111, 0.012).positions;
    const SurfaceStatistics a = felt(other, array, apart.fields);
    const SurfaceStatistics b = felt(other, array, together.fields);
    EXPECT_LT(b.coefficientOfVariation, 0.3 * a.coefficientOfVariation);
    EXPECT_GT(b.mean_Pa, a.mean_Pa);
    // Its figures are of what is felt: of all fields together at each point.
    EXPECT_LT(together.report.rms, 0.1);
    EXPECT_NEAR(radiationPressure(together.report.level_Pa, Medium()), b.mean_Pa, 0.1 * b.mean_Pa);
    EXPECT_GT(together.report.driveChange, 0.0);
    const Eigen::VectorXf achieved = achievedPressure(together, array, Medium(), 1);
    ASSERT_EQ(achieved.size(), 64);
    EXPECT_NEAR(achieved.mean(), together.report.level_Pa, 0.05 * together.report.level_Pa);
}

TEST(SequenceComposer, StepsBetweenEvenedFieldsStandWhereTheyStoodBefore)
{
    const TransducerArray array = TransducerArray::singleBoard();
    std::vector<ControlPoints> sets = turnedSpheres(3, 5, 0.012);
    for (ControlPoints& set : sets)
        set.positions.row(2).array() += 0.12;
    ControlPoints places = spherePoints(200, 0.012, {0, 0, 0.12});
    ComposerOptions options;
    options.cycleSteps = 2;
    options.even = 10;
    const FieldSequence cycle = cycleOf(sets, array, options, places);
    ASSERT_TRUE(cycle.evened);
    ASSERT_EQ(cycle.fields.size(), 9u);
    for (std::size_t k = 0; k < cycle.parts.size(); ++k)
        EXPECT_EQ(cycle.parts[k].size() > 0, k % 3 == 0) << k;
    const std::vector<Eigen::VectorXcf> fields{cycle.fields[0], cycle.fields[3], cycle.fields[6]};
    EXPECT_EQ(smoothedFields(fields, 2, array.drive), cycle.fields);
}

TEST(SequenceComposer, PointsInPaAndSubsetsAreNotEvenedOut)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const ControlPoints places = spherePoints(300, 0.012);
    std::vector<ControlPoints> sets = turnedSpheres(2, 8, 0.012);
    ComposerOptions options;
    options.subsets = 2;
    EXPECT_FALSE(cycleOf(sets, array, options, places).evened);
    for (ControlPoints& set : sets)
    {
        set.absolute = true;
        set.targets *= 500.0;
    }
    const FieldSequence inPa = cycleOf(sets, array, {}, places);
    EXPECT_FALSE(inPa.evened);
    EXPECT_NEAR(inPa.report.level_Pa, 500.0, 10.0);
}

TEST(SequenceComposer, ASetWithoutPointsStaysSilentWhileTheOthersAreEvenedOut)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const ControlPoints places = spherePoints(300, 0.012);
    std::vector<ControlPoints> sets = turnedSpheres(2, 16, 0.012);
    sets.insert(sets.begin(), ControlPoints());
    const FieldSequence cycle = cycleOf(sets, array, {}, places);
    EXPECT_TRUE(cycle.evened);
    ASSERT_EQ(cycle.parts.size(), 3u);
    EXPECT_EQ(cycle.points().size(), 32);
    for (std::size_t k = 0; k < cycle.fields.size(); ++k)
    {
        ASSERT_TRUE(cycle.fields[k].allFinite());
        EXPECT_EQ(cycle.fields[k].isZero(0.0f), cycle.parts[k].size() == 0);
    }
    const FieldSequence none = cycleOf({ControlPoints(), ControlPoints()}, array, {}, places);
    for (const Eigen::VectorXcf& q : none.fields)
        EXPECT_TRUE(q.isZero(0.0f));
}

std::vector<ControlPoints> pointsAlongALine(const std::vector<int>& places)
{
    std::vector<ControlPoints> sets;
    for (const int place : places)
    {
        ControlPoints points;
        points.positions.resize(3, 1);
        points.positions << 0.004 * place, 0.0, 0.1;
        points.normals.resize(3, 1);
        points.normals << 0, 0, 1;
        points.targets = Eigen::VectorXd::Ones(1);
        sets.push_back(points);
    }
    return sets;
}

// Points in a shuffled order: what the cycle makes of it changes less than the order as given, and
// each part stands where its field is.
TEST(SequenceComposer, OrdersAndAlignsForTheLeastChange)
{
    const TransducerArray array = TransducerArray::singleBoard();
    const std::vector<ControlPoints> sets = pointsAlongALine({0, 3, 1, 4, 2});
    const FieldSequence ordered = cycleOf(sets, array);
    ComposerOptions options;
    options.reorder = false;
    const FieldSequence asGiven = cycleOf(sets, array, options);
    EXPECT_LT(ordered.report.driveChange, asGiven.report.driveChange);
    const Eigen::VectorXf achieved_Pa = achievedPressure(ordered, array, Medium(), 1);
    for (Eigen::Index l = 0; l < achieved_Pa.size(); ++l)
        for (std::size_t k = 0; k < ordered.fields.size(); ++k)
            EXPECT_LE(std::abs(pressureAt(ordered.parts[static_cast<std::size_t>(l)].positions,
                                          array,
                                          Medium(),
                                          ordered.fields[k])[0]),
                      1.0001f * achieved_Pa[l])
                << "no other field is louder where this one is for";
    // No common phase of any field lowers the change of the aligned cycle by more than a level's
    // rounding.
    std::vector<Eigen::VectorXcf> turned = ordered.fields;
    for (std::size_t k = 0; k < turned.size(); ++k)
        for (const float angle : {0.2f, -0.2f})
        {
            turned[k] = ordered.fields[k] * std::polar(1.0f, angle);
            EXPECT_GT(cycleSteps(turned).driveChange, ordered.report.driveChange);
            turned[k] = ordered.fields[k];
        }
}

TEST(SequenceComposer, StepsBetweenFieldsTurnTheShorterWayAndStayPlayable)
{
    const TransducerArray array = TransducerArray::singleBoard();
    std::vector<ControlPoints> sets(3);
    for (int k = 0; k < 3; ++k)
        sets[static_cast<std::size_t>(k)] = spherePoints(4, 0.01, {0.01 * k, 0, 0.1});
    const FieldSequence cycle = cycleOf(sets, array);
    const CycleSteps plain = cycleSteps(cycle.fields);
    ComposerOptions options;
    options.cycleSteps = 3;
    const FieldSequence smooth = cycleOf(sets, array, options);
    ASSERT_EQ(smooth.fields.size(), 12u);
    EXPECT_EQ(smooth.fields[4], cycle.fields[1]);
    ASSERT_EQ(smooth.parts.size(), 12u);
    EXPECT_EQ(smooth.parts[4].positions, cycle.parts[1].positions);
    EXPECT_EQ(smooth.parts[5].size(), 0);
    EXPECT_EQ(achievedPressure(smooth, array, Medium(), 1),
              achievedPressure(cycle, array, Medium(), 1));
    const CycleSteps steps = cycleSteps(smooth.fields);
    EXPECT_EQ(steps.driveChange, smooth.report.driveChange);
    EXPECT_NEAR(steps.meanPhaseStep_rad, plain.meanPhaseStep_rad / 4, 0.01); // 8-bit levels
    EXPECT_LT(steps.largestPhaseStep_rad, M_PI / 4 + 2 * M_PI / 256);
    EXPECT_LT(steps.driveChange, plain.driveChange / 8);
    for (const Eigen::VectorXcf& q : smooth.fields)
        for (const std::complex<float>& value : q)
        {
            const double level = std::arg(value) * 256.0 / (2.0 * M_PI);
            EXPECT_NEAR(level, std::round(level), 1e-3);
        }
    EXPECT_THROW(smoothedFields(cycle.fields, -1, array.drive), base::InputError);
}

TEST(SequenceComposer, SubsetsOfSeveralSetsPlayAtOneLevel)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    std::vector<ControlPoints> sets = {spherePoints(30, 0.02), spherePoints(8, 0.02)};
    ComposerOptions options;
    options.subsets = 2;
    const FieldSequence cycle = cycleOf(sets, array, options);
    ASSERT_EQ(cycle.fields.size(), 4u);
    const Eigen::VectorXf achieved_Pa = achievedPressure(cycle, array, Medium(), 1);
    EXPECT_LT(achieved_Pa.maxCoeff() / achieved_Pa.minCoeff(), 1.05f);
    SolveReport rated = cycle.report;
    rateLevel(cycle.points(), achieved_Pa, rated);
    EXPECT_LT(rated.rms, 0.02);
}

TEST(SequenceComposer, TargetsInPaArePlayedInEachFieldAndNeedNoOtherSolver)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    base::MessageLog messages;
    ComposerOptions options;
    options.subsets = 2;
    SequenceComposer composer(options, messages);
    ControlPoints points = spherePoints(20, 0.02);
    const FieldSequence relative = composer.compose(0, points, {}, array, Medium());
    points.targets.setConstant(500.0);
    points.absolute = true;
    const FieldSequence inPa = composer.compose(0, points, {}, array, Medium());
    EXPECT_TRUE(inPa.parts.front().absolute);
    for (const float p : achievedPressure(inPa, array, Medium(), 1))
        EXPECT_NEAR(p, 500.0f, 10.0f);
    points.targets.setOnes();
    points.absolute = false;
    const FieldSequence again = composer.compose(0, points, {}, array, Medium());
    EXPECT_NEAR(again.report.level_Pa, relative.report.level_Pa, 0.1 * relative.report.level_Pa);
}

TEST(SequenceComposer, AnOutlineIsAsLoudAsItIsAskedToBe)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    Outline circle = Outline::circle({0, 0, 0}, 0.034, {0, 1, 0});
    const auto composed = [&](double loudness, double target, bool absolute)
    {
        base::MessageLog messages;
        ComposerOptions options;
        options.solverOptions.loudness = loudness;
        circle.target = target;
        SequenceComposer composer(options, messages);
        return composer.composeOutlines({circle}, absolute, {}, array, Medium());
    };
    const FieldSequence full = composed(1.0, 1.0, false);
    ASSERT_TRUE(full.isHeld());
    EXPECT_EQ(full.report.solver, "outline");
    EXPECT_EQ(full.report.points, full.points().size());
    EXPECT_GT(full.report.loudness, 0.3);
    const FieldSequence half = composed(0.5, 1.0, false);
    EXPECT_NEAR(half.report.level_Pa, 0.5 * full.report.level_Pa, 0.02 * full.report.level_Pa);
    EXPECT_NEAR(half.report.rms, full.report.rms, 0.01);
    EXPECT_EQ(full.report.message, "");
    const FieldSequence louder = composed(1.5, 1.0, false);
    EXPECT_EQ(louder.report.level_Pa, full.report.level_Pa);
    EXPECT_EQ(louder.report.message,
              "a loudness of 1.5 counts as 1: outlines are as loud as they can be smooth");
    // To half a level of amplitude.
    const FieldSequence inPa = composed(1.0, 3000.0, true);
    EXPECT_NEAR(inPa.report.level_Pa, 3000.0, 60.0);
    EXPECT_EQ(inPa.points().targets.maxCoeff(), 3000.0);
}

TEST(SequenceComposer, SaysWhatIsWrong)
{
    const auto failing = [&](const std::vector<ControlPoints>& sets)
    {
        try
        {
            cycleOf(sets, TransducerArray::singleBoard());
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
    ComposerOptions unknown;
    unknown.makeSolver = [] { return makeSolver("unheard-of"); };
    EXPECT_THROW(cycleOf({spherePoints(2, 0.01)}, TransducerArray::singleBoard(), unknown),
                 base::InputError);
}

} // namespace
} // namespace midair::haptics
