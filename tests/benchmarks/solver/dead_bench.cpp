// What dead transducers cost a solve: nothing. The same scene in the octagon and in one of which a
// share is dead, turn by turn; the ratio of the times should be that of the transducers left.
#include "haptics/base/Percentile.h"
#include "haptics/solvers/HologramSolver.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <cstdio>
#include <memory>
#include <vector>

#include <CLI/CLI.hpp>

using namespace midair::haptics;

namespace
{

/// Medians of an update after a move of 1 mm, in ms: the matrix, and all of it.
struct Times
{
    double matrix_ms, total_ms;
};

class Runner
{
public:
    explicit Runner(const TransducerArray& array, int points) :
        _array(array),
        _points(spherePoints(points, 0.03)),
        _solver(makeSolver(solverNames().front()))
    {
    }

    void update(int k)
    {
        ControlPoints moved = _points;
        moved.positions.row(0).array() += 1e-3 * (k % 5);
        const SolveReport report = _solver->solve(moved, _array, Medium(), _q);
        _matrix_ms.push_back(report.matrix_ms);
        _total_ms.push_back(report.matrix_ms + report.solve_ms);
    }

    Times medians() const
    {
        return {midair::base::percentile(_matrix_ms, 0.5),
                midair::base::percentile(_total_ms, 0.5)};
    }

private:
    TransducerArray _array;
    ControlPoints _points;
    std::unique_ptr<HologramSolver> _solver;
    Eigen::VectorXcf _q;
    std::vector<double> _matrix_ms, _total_ms;
};

} // namespace

int main(int argc, char** argv)
{
    int points = 100, updates = 200;
    CLI::App app("Compares update times of the octagon with some dead transducers to those of the "
                 "intact octagon.",
                 "midair-dead-bench");
    app.add_option("--n", points, "Number of control points")->check(CLI::Range(1, 1000));
    app.add_option("--updates", updates, "Updates per array")->check(CLI::Range(10, 100000));
    CLI11_PARSE(app, argc, argv);
    const TransducerArray whole = TransducerArray::octagonalPrism();
    std::printf("%d points, updates after a move of 1 mm, one thread; ms (over the octagon's)\n"
                "  dead    matrix           all\n",
                points);
    for (const int everyNth : {16, 4, 2})
    {
        TransducerArray array = whole;
        std::vector<int> dead;
        for (int i = 0; i < array.size(); i += everyNth)
            dead.push_back(i);
        array.setDead(dead);
        Runner all(whole, points), rest(array, points);
        for (int k = 0; k < updates; ++k)
        {
            all.update(k);
            rest.update(k);
        }
        const Times a = all.medians(), b = rest.medians();
        std::printf("%5.1f %%  %6.3f (%.2f)   %6.3f (%.2f)\n",
                    100.0 * static_cast<double>(dead.size()) / whole.size(),
                    b.matrix_ms,
                    b.matrix_ms / a.matrix_ms,
                    b.total_ms,
                    b.total_ms / a.total_ms);
    }
    return 0;
}
