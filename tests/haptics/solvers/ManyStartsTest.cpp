#include "haptics/solvers/ManyStarts.h"

#include "tests/haptics/solvers/ScenePoints.h"

#include <algorithm>
#include <map>
#include <vector>

#include <gtest/gtest.h>

namespace midair::haptics
{
namespace
{

/// A solver whose figures depend on its seed alone.
class Seeded : public HologramSolver
{
public:
    Seeded(const SolverOptions& options, std::map<int, int>& calls, StopReason stop) :
        _options(options),
        _calls(calls),
        _stop(stop)
    {
    }
    SolveReport solve(const ControlPoints& /*points*/,
                      const TransducerArray& array,
                      const Medium& /*medium*/,
                      Eigen::VectorXcf& q) override
    {
        const int seed = static_cast<int>(_options.seed);
        ++_calls[seed];
        q = Eigen::VectorXcf::Constant(array.size(), static_cast<float>(seed));
        SolveReport report;
        report.stop = _stop;
        report.rms = seed == 3 ? 0.5 : 1e-4;      // 3 is the loudest, and wrong
        report.loudness = seed == 3 ? 2.0 : seed; // of the others 4 is
        report.solve_ms = 1.0;
        if (_stop == StopReason::MAX_ITERATIONS) // better each time, up to the fourth
            report.rms = std::max(0.1, 1.6 / (1 << _calls[seed]));
        return report;
    }
    const SolverOptions& options() const override { return _options; }

private:
    const SolverOptions _options;
    std::map<int, int>& _calls;
    const StopReason _stop;
};

TEST(ManyStarts, GoesOnWithTheLoudestOfThoseThatAreRight)
{
    std::map<int, int> calls;
    ManyStarts solver([&](const SolverOptions& options)
                      { return std::make_unique<Seeded>(options, calls, StopReason::CONVERGED); },
                      {},
                      4);
    Eigen::VectorXcf q;
    const TransducerArray array = TransducerArray::singleBoard();
    const SolveReport first = solver.solve(gridPoints(1, 1, 1, 0.01), array, {}, q);
    EXPECT_EQ(q(0).real(), 4.0f);
    EXPECT_EQ(first.loudness, 4.0);
    EXPECT_EQ(first.solve_ms, 4.0); // of all starts
    solver.solve(gridPoints(1, 1, 1, 0.01), array, {}, q);
    EXPECT_EQ(calls, (std::map<int, int>{{1, 1}, {2, 1}, {3, 1}, {4, 2}}));
}

TEST(ManyStarts, AFieldThatGetsBetterIsSolvedForAgain)
{
    std::map<int, int> calls;
    ManyStarts solver(
        [&](const SolverOptions& options)
        { return std::make_unique<Seeded>(options, calls, StopReason::MAX_ITERATIONS); },
        {},
        1);
    Eigen::VectorXcf q;
    const TransducerArray array = TransducerArray::singleBoard();
    const SolveReport report = solver.solve(gridPoints(1, 1, 1, 0.01), array, {}, q);
    EXPECT_EQ(report.rms, 0.1);
    EXPECT_EQ(calls[1], 5); // the fourth is as good as it gets
}

TEST(ManyStarts, AMethodThatThereIsNotIsToldAtOnce)
{
    EXPECT_ANY_THROW(
        ManyStarts([](const SolverOptions& each) { return makeSolver("none", each); }, {}, 2));
}

TEST(ManyStarts, ARefusalEndsThem)
{
    for (const StopReason stop :
         {StopReason::REFUSED, StopReason::STOPPED, StopReason::NOTHING_TO_DO})
    {
        std::map<int, int> calls;
        ManyStarts solver([&](const SolverOptions& options)
                          { return std::make_unique<Seeded>(options, calls, stop); },
                          {},
                          4);
        Eigen::VectorXcf q;
        const TransducerArray array = TransducerArray::singleBoard();
        EXPECT_EQ(solver.solve(gridPoints(1, 1, 1, 0.01), array, {}, q).stop, stop);
        EXPECT_EQ(calls, (std::map<int, int>{{1, 1}}));
        solver.solve(gridPoints(1, 1, 1, 0.01), array, {}, q); // is the first one again
        EXPECT_EQ(calls[1], 2);
    }
}

TEST(ManyStarts, AreNotWorseThanOne)
{
    TransducerArray array = TransducerArray::octagonalPrism();
    SolverOptions options;
    Eigen::VectorXcf one;
    Eigen::VectorXcf best;
    const ControlPoints points = spherePoints(12, 0.03);
    const SolveReport single = makeSolver("gauss-newton", options)->solve(points, array, {}, one);
    ManyStarts solver(
        [](const SolverOptions& each) { return makeSolver("gauss-newton", each); }, options, 6);
    const SolveReport many = solver.solve(points, array, {}, best);
    EXPECT_FALSE(ManyStarts::isBetter(single, many, options.rmsTolerance));
    EXPECT_GT(many.loudness, single.loudness);
}

TEST(ManyStarts, ThoroughRoundingLowersTheErrorOfUpdates)
{
    TransducerArray array = TransducerArray::octagonalPrism();
    array.drive.amplitudeLevels = {0.0f, 1.0f};
    double rms[2] = {0.0, 0.0};
    for (const bool thorough : {false, true})
    {
        SolverOptions options;
        options.thorough = thorough;
        options.rmsTolerance = 0.0;
        const auto solver = makeSolver("gauss-newton", options);
        Eigen::VectorXcf q;
        for (int k = 0; k < 8; ++k)
        {
            const SolveReport report =
                solver->solve(spherePoints(40, 0.04, {1e-3 * k, 0, 0}), array, {}, q);
            if (k > 0) rms[thorough ? 1 : 0] += report.rms / 7.0;
        }
    }
    EXPECT_LT(rms[1], rms[0]);
}

} // namespace
} // namespace midair::haptics
