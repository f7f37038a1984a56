// An array's source amplitude scales pressures and nothing else, over the whole range that arrays
// may have.
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/SurfaceStatistics.h"
#include "haptics/sequence/CycleEqualizer.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/solvers/dense/OutlineHologram.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <cmath>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

// Of figures. Greedy takes another level where two are equal but for rounding, and then goes
// another way to a field that is about as good.
double sameFor(const std::string& solver)
{
    return solver == "greedy" ? 0.1 : 1e-3;
}

TransducerArray prismOf(double source_Pa_m)
{
    TransducerArray array = TransducerArray::octagonalPrism();
    array.sourceAmplitude_Pa_m = source_Pa_m;
    return array;
}

// The field after a cold start and two moves, as a scene has it.
struct MovedField
{
    SolveReport report;
    Eigen::VectorXcf q;
};

MovedField movedField(const std::string& name,
                      ControlPoints points,
                      const TransducerArray& array,
                      const SolverOptions& options = {})
{
    MovedField field;
    const auto solver = makeSolver(name, options);
    for (int step = 0; step < 3; ++step)
    {
        field.report = solver->solve(points, array, Medium{}, field.q);
        points.positions.row(0).array() += 0.1e-3;
    }
    return field;
}

double sumOf(const ControlPoints& points, const TransducerArray& array, const Eigen::VectorXcf& q)
{
    return pressureAt(points.positions, array, Medium{}, q).cwiseAbs().cast<double>().sum();
}

void expectSame(const SolveReport& report, const SolveReport& one, double source_Pa_m)
{
    const double same = sameFor(one.solver);
    EXPECT_EQ(report.stop, one.stop) << report.message;
    EXPECT_NEAR(report.rms, one.rms, same);
    EXPECT_NEAR(report.max, one.max, same);
    EXPECT_NEAR(report.loudness, one.loudness, same * one.loudness);
    EXPECT_NEAR(report.level_Pa / source_Pa_m, one.level_Pa, same * one.level_Pa);
    EXPECT_NEAR(report.levelJump, one.levelJump, same);
}

} // namespace

TEST(EverySolver, HasTheSameFiguresForAnySourceAmplitude)
{
    const ControlPoints points = spherePoints(20, 0.03);
    for (const std::string& name : solverNames())
    {
        const MovedField one = movedField(name, points, prismOf(1.0));
        for (const double source_Pa_m : {kLeastSource_Pa_m, 1e-10, 1e10, 1e20, kMostSource_Pa_m})
        {
            SCOPED_TRACE(name + " " + std::to_string(std::log10(source_Pa_m)));
            const MovedField field = movedField(name, points, prismOf(source_Pa_m));
            expectSame(field.report, one.report, source_Pa_m);
            // What it really plays, apart from the units of the solver.
            const double sum = sumOf(points, prismOf(source_Pa_m), field.q) / source_Pa_m;
            const double wanted = sumOf(points, prismOf(1.0), one.q);
            EXPECT_NEAR(sum, wanted, sameFor(name) * wanted);
        }
    }
}

TEST(EverySolver, IsTheSameToTheBitForSourceAmplitudesThatDifferByAPowerOfTwo)
{
    const ControlPoints points = spherePoints(20, 0.03);
    for (const std::string& name : solverNames())
    {
        SCOPED_TRACE(name);
        const MovedField one = movedField(name, points, prismOf(1.0));
        for (const double source_Pa_m : {0x1p-99, 0x1p-12, 0x1p66, 0x1p99})
        {
            const MovedField field = movedField(name, points, prismOf(source_Pa_m));
            EXPECT_EQ(field.q, one.q) << source_Pa_m;
            EXPECT_EQ(field.report.rms, one.report.rms);
            EXPECT_EQ(field.report.level_Pa, source_Pa_m * one.report.level_Pa);
        }
    }
}

TEST(EverySolver, MeetsTargetsInPaForAnySourceAmplitude)
{
    ControlPoints points = spherePoints(20, 0.03);
    points.absolute = true;
    const Eigen::VectorXd shares = points.targets;
    for (const std::string& name : solverNames())
        for (const double share_Pa : {50.0, 1e6}) // the latter is more than the array can
        {
            points.targets = share_Pa * shares;
            const MovedField one = movedField(name, points, prismOf(1.0));
            for (const double source_Pa_m : {1e-30, 1e-10, 1e5})
            {
                SCOPED_TRACE(name + " " + std::to_string(std::log10(source_Pa_m)));
                points.targets = share_Pa * source_Pa_m * shares;
                const MovedField field = movedField(name, points, prismOf(source_Pa_m));
                expectSame(field.report, one.report, source_Pa_m);
                // The other way of greedy may leave some points a percent below.
                if (name != "greedy")
                {
                    EXPECT_EQ(field.report.shortPoints, one.report.shortPoints);
                }
                EXPECT_NEAR(field.report.worstShortfall, one.report.worstShortfall, sameFor(name));
            }
        }
}

TEST(EverySolver, TakesFaintGainsLikeAFaintSource)
{
    const ControlPoints points = spherePoints(20, 0.03);
    TransducerArray array = prismOf(1.0);
    array.gain.setConstant(array.size(), 0x1p-90);
    for (const std::string& name : solverNames())
    {
        SCOPED_TRACE(name);
        EXPECT_EQ(movedField(name, points, array).q, movedField(name, points, prismOf(1.0)).q);
    }
}

TEST(EverySolver, RefusesSourceAmplitudesOutOfTheirRange)
{
    for (const double source_Pa_m : {0.0, -1.0, 1e-31, 1e31, std::nan("")})
    {
        std::string error;
        EXPECT_FALSE(prismOf(source_Pa_m).isValid(&error));
        EXPECT_NE(error.find("must be within 1e-30 .. 1e+30"), std::string::npos) << error;
        for (const std::string& name : solverNames())
        {
            Eigen::VectorXcf q;
            const SolveReport report =
                makeSolver(name)->solve(spherePoints(4, 0.03), prismOf(source_Pa_m), Medium{}, q);
            EXPECT_EQ(report.stop, StopReason::REFUSED);
            EXPECT_NE(report.message.find("must be within 1e-30 .. 1e+30"), std::string::npos)
                << report.message;
        }
    }
}

TEST(OutlineHologram, IsTheSameForAnySourceAmplitude)
{
    const Outline circle = Outline::circle({0, 0, 0}, 0.02, {0, 1, 0});
    OutlineOptions options;
    options.starts = options.finalists = 1;
    options.corrections = 6;
    const auto solved = [&](double source_Pa_m, OutlineReport& report)
    {
        Eigen::VectorXcf q;
        report = OutlineHologram(options).solve({circle}, prismOf(source_Pa_m), Medium{}, q);
        return q;
    };
    OutlineReport one, other;
    const Eigen::VectorXcf q = solved(1.0, one);
    for (const double source_Pa_m : {0x1p-99, 0x1p66})
    {
        EXPECT_EQ(solved(source_Pa_m, other), q);
        EXPECT_EQ(other.along.coefficientOfVariation, one.along.coefficientOfVariation);
        EXPECT_NEAR(other.along.mean_Pa / (source_Pa_m * source_Pa_m),
                    one.along.mean_Pa,
                    1e-9 * one.along.mean_Pa);
    }
}

TEST(CycleEqualizer, IsTheSameForAnySourceAmplitude)
{
    const ControlPoints points = spherePoints(12, 0.02);
    const ControlPoints places = spherePoints(60, 0.02);
    CycleEqualizerOptions options;
    options.passes = 3;
    const auto evened = [&](double source_Pa_m)
    {
        std::vector<Eigen::VectorXcf> fields(2);
        ControlPoints turned = points;
        for (Eigen::VectorXcf& q : fields)
        {
            makeSolver(solverNames().front())->solve(turned, prismOf(1.0), Medium{}, q);
            turned.positions.row(1).swap(turned.positions.row(2));
        }
        CycleEqualizer equalizer(options, {});
        EXPECT_TRUE(equalizer.begin(places, prismOf(source_Pa_m), Medium{}, fields));
        while (equalizer.step())
            ;
        EXPECT_EQ(equalizer.passes(), options.passes);
        return equalizer.fields();
    };
    const std::vector<Eigen::VectorXcf> one = evened(1.0);
    for (const double source_Pa_m : {0x1p-99, 0x1p66})
        EXPECT_EQ(evened(source_Pa_m), one);
}
