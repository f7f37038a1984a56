// The Monte Carlo study against closed forms, and against the reference in double.
#include "haptics/tolerance/ToleranceStudy.h"

#include "haptics/array/BoardGrid.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/sequence/FieldSequence.h"
#include "tests/haptics/propagation/ChangedPhysics.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <cmath>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::haptics;

namespace
{

struct Solved
{
    TransducerArray array;
    Medium medium;
    FieldSequence sequence;
};

Solved solved(TransducerArray array, const ControlPoints& points)
{
    Solved all;
    all.array = std::move(array);
    Eigen::VectorXcf q;
    all.sequence.report =
        makeSolver(solverNames().front())->solve(points, all.array, all.medium, q);
    all.sequence.fields = {q};
    all.sequence.parts = {points};
    return all;
}

const Solved& sphere()
{
    static const Solved all = solved(TransducerArray::octagonalPrism(), spherePoints(40, 0.03));
    return all;
}

ToleranceOptions nothing()
{
    ToleranceOptions options;
    options.position_m.clear();
    options.tilt_deg.clear();
    options.phase_deg.clear();
    options.temperature_K.clear();
    options.dead.clear();
    options.draws = 10;
    return options;
}

ToleranceStudy study(const Solved& of, const ToleranceOptions& options)
{
    return toleranceOf(of.sequence, of.array, of.medium, options);
}

} // namespace

// |sum e^{j delta}| of independent normal phases: e^{-s^2/2} of the whole, with a spread of
// sqrt((1 - e^{-s^2})/m) of a single array: 0.01 at 3984 transducers.
TEST(Tolerance, PhasesLeaveAFocusByTheGaussian)
{
    ToleranceOptions options = nothing();
    options.phase_deg = {5.0, 15.0, 30.0, 60.0};
    for (const ToleranceRow& row : study(sphere(), options).rows)
    {
        const double s = base::toRadians(row.value);
        EXPECT_NEAR(row.focus, std::exp(-0.5 * s * s), 0.01) << row.value;
        EXPECT_NEAR(row.expectedFocus, std::exp(-0.5 * s * s), 1e-12);
        EXPECT_NEAR(row.loudness, sphere().sequence.report.loudness * row.expectedFocus, 0.015);
    }
}

// Independent phases change p_l by sum G_li q_i j delta_i, whose size is s |G_l| = s |p_l|
// sqrt(n/m)/E where all transducers are equally strong; of it |p_l| has the part along p_l, half of
// the square where the waves at a point have all phases. Strengths that differ and 40 points leave
// some 10 %.
TEST(Tolerance, PhasesAddTheErrorOfTheFormula)
{
    ToleranceOptions options = nothing();
    options.phase_deg = {5.0, 10.0, 15.0};
    options.draws = 30;
    const ToleranceStudy found = study(sphere(), options);
    for (const ToleranceRow& row : found.rows)
    {
        const double added = base::toRadians(row.value) * std::sqrt(0.5 * 40.0 / 3984.0) /
                             sphere().sequence.report.loudness;
        EXPECT_NEAR(row.expectedRms, std::hypot(found.nominal.rms, added), 1e-7);
        EXPECT_NEAR(row.rms / row.expectedRms, 1.0, 0.1) << row.value;
        EXPECT_GE(row.rms90, row.rms);
    }
}

// A share d of dead ones takes that share of a focus; which ones are dead varies it by their
// different strengths, sqrt(d/m) and less.
TEST(Tolerance, TheDeadTakeTheirShare)
{
    ToleranceOptions options = nothing();
    options.dead = {0.01, 0.1, 0.5, 1.0};
    for (const ToleranceRow& row : study(sphere(), options).rows)
    {
        EXPECT_NEAR(row.focus, 1.0 - row.value, 0.01) << row.value;
        EXPECT_EQ(row.expectedFocus, 1.0 - row.value);
        EXPECT_NEAR(row.loudness,
                    sphere().sequence.report.loudness * (1.0 - row.value),
                    0.02 * sphere().sequence.report.loudness);
    }
}

// One board moved as a whole away from a focus turns its waves by k times the way along their
// direction: the two boards of face to face arrive out of step.
TEST(Tolerance, DisplacedBoardsAreDisplacedAsAWhole)
{
    TransducerArray array = TransducerArray::octagonalPrism();
    const std::vector<BoardRange> boards = boardsOf(array);
    ASSERT_EQ(boards.size(), 16U);
    EXPECT_EQ(boards[3].first, 3 * 249);
    EXPECT_EQ(boards[3].count, 249);
    const TransducerArray before = array;
    const Eigen::Isometry3d motion =
        Eigen::Translation3d(0.001, -0.002, 0.003) *
        Eigen::AngleAxisd(0.1, Eigen::Vector3d(1.0, 2.0, 3.0).normalized());
    moveBoard(motion, boards[3], array);
    for (int i = 0; i < array.size(); ++i)
    {
        const bool isMoved = i >= 3 * 249 && i < 4 * 249;
        const Eigen::Vector3d place = before.positions.col(i), normal = before.normals.col(i);
        const Eigen::Vector3d wanted = isMoved ? Eigen::Vector3d(motion * place) : place;
        const Eigen::Vector3d facing = isMoved ? Eigen::Vector3d(motion.linear() * normal) : normal;
        EXPECT_LT((array.positions.col(i) - wanted).norm(), 1e-15);
        EXPECT_LT((array.normals.col(i) - facing).norm(), 1e-15);
    }
    EXPECT_TRUE(array.isValid());
}

// 16 boards off by v along their waves are 16 phases of spread k v: a focus keeps e^{-(k v)^2/2} of
// the mean, and of a single draw the more, the fewer boards there are: E|mean|^2 = e^{-s^2} +
// (1 - e^{-s^2})/16.
TEST(Tolerance, DisplacedBoardsCostAFocusLikePhases)
{
    ToleranceOptions options = nothing();
    options.position_m = {0.5e-3};
    options.draws = 60;
    const double k = base::kTwoPi / sphere().medium.wavelength(40e3);
    const double s = k * 0.5e-3;
    const double square = std::exp(-s * s) + (1.0 - std::exp(-s * s)) / 16.0;
    const ToleranceStudy found = study(sphere(), options);
    EXPECT_NEAR(found.rows.front().focus, std::sqrt(square), 0.01);
    EXPECT_GT(found.rows.front().rms, 3.0 * found.nominal.rms);
}

// The study's single precision and its rating against the reference in double.
TEST(Tolerance, AgreesWithTheReference)
{
    ToleranceOptions options = nothing();
    options.temperature_K = {-2.0, 3.0};
    const Solved& of = sphere();
    for (const ToleranceRow& row : study(of, options).rows)
    {
        EXPECT_EQ(row.draws, 1);
        Medium warmer = of.medium;
        warmer.temperature_C += row.value;
        const ChangedField reference =
            changedField(of.sequence.parts.front(), of.array, warmer, of.sequence.fields.front());
        EXPECT_NEAR(row.rms, reference.rms, 1e-5);
        EXPECT_NEAR(row.loudness / of.sequence.report.loudness,
                    reference.level_Pa / of.sequence.report.level_Pa,
                    1e-4);
    }
}

TEST(Tolerance, SeedsDecideTheDraws)
{
    ToleranceOptions options = nothing();
    options.tilt_deg = {0.2};
    options.draws = 3;
    const double first = study(sphere(), options).rows.front().rms;
    EXPECT_EQ(study(sphere(), options).rows.front().rms, first);
    options.seed = 2;
    EXPECT_NE(study(sphere(), options).rows.front().rms, first);
}

TEST(Tolerance, NothingDeviatesByNothing)
{
    ToleranceOptions options = nothing();
    options.position_m = options.tilt_deg = options.phase_deg = options.dead = {0.0};
    options.draws = 1;
    const ToleranceStudy found = study(sphere(), options);
    ASSERT_EQ(found.rows.size(), 4U);
    EXPECT_NEAR(found.nominal.focus, 1.0, 1e-4);
    EXPECT_NEAR(found.nominal.rms, sphere().sequence.report.rms, 1e-5);
    for (const ToleranceRow& row : found.rows)
    {
        EXPECT_NEAR(row.rms, found.nominal.rms, 1e-5) << deviationName(row.deviation);
        EXPECT_NEAR(row.focus, 1.0, 1e-4) << deviationName(row.deviation);
    }
    EXPECT_EQ(found.arrays, 5);
}

TEST(Tolerance, ImpossibleRangesAreRefused)
{
    const auto whyNot = [](const ToleranceOptions& options) -> std::string
    {
        try
        {
            study(sphere(), options);
        }
        catch (const base::InputError& error)
        {
            return error.what();
        }
        return {};
    };
    ToleranceOptions options = nothing();
    options.dead = {0.1, 1.5};
    EXPECT_EQ(whyNot(options), "tolerance: dead is 1.5; it must be within 0 .. 1");
    options = nothing();
    options.temperature_K = {45.0};
    EXPECT_NE(whyNot(options).find("65"), std::string::npos) << whyNot(options);
    options = nothing();
    options.position_m = {std::nan("")};
    EXPECT_EQ(whyNot(options), "tolerance: position_m is nan; it must be within 0 .. 0.1");
    Solved silent = sphere();
    silent.sequence.report.level_Pa = 0.0;
    EXPECT_THROW(study(silent, nothing()), base::InputError);
}
