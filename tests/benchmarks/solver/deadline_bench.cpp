// midair-deadline-bench: how well the production solver keeps deadlines, from one matrix build
// upwards, and what a field loses by them.

#include "haptics/array/TransducerArray.h"
#include "haptics/solvers/HologramSolver.h"
#include "tests/benchmarks/Timing.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <algorithm>
#include <cstdio>
#include <vector>

#include <CLI/CLI.hpp>

using namespace midair::haptics;
using midair::bench::median;

namespace
{

/// Returns the median time of a matrix build, ms.
double build_ms(int n, const TransducerArray& array)
{
    std::vector<double> times;
    Eigen::VectorXcf q;
    SolverOptions options;
    options.skipTolerance = 0.0;
    const auto solver = makeSolver("gauss-newton", options);
    for (int k = 0; k < 15; ++k)
        times.push_back(
            solver->solve(spherePoints(n, 0.05, {1e-4 * k, 0, 0}), array, Medium(), q).matrix_ms);
    return median(times);
}

void race(int n, double deadline_ms, bool warm, int solves, const TransducerArray& array)
{
    SolverOptions options;
    options.skipTolerance = 0.0;
    options.deadline_ms = deadline_ms;
    options.warmStart = warm;
    const auto solver = makeSolver("gauss-newton", options);
    std::vector<double> times, rms, loudness;
    int kept = 0;
    Eigen::VectorXcf q;
    for (int k = 0; k < solves; ++k)
    {
        const ControlPoints points = spherePoints(n, 0.05, {1e-4 * k, 0, 0});
        const double start = midair::bench::wall_ms();
        const SolveReport report = solver->solve(points, array, Medium(), q);
        const double took = midair::bench::wall_ms() - start;
        if (k < solves / 10) continue;
        times.push_back(took);
        rms.push_back(report.rms);
        loudness.push_back(report.loudness);
        kept += took <= std::max(1.2 * deadline_ms, deadline_ms + 0.1);
    }
    std::printf("%5d %-5s %9.3f  %9.3f %9.3f %7.1f %%  %9.4f %7.3f\n",
                n,
                warm ? "warm" : "cold",
                deadline_ms,
                median(times),
                *std::max_element(times.begin(), times.end()),
                100.0 * kept / static_cast<double>(times.size()),
                100.0 * median(rms),
                median(loudness));
    std::fflush(stdout);
}

} // namespace

int main(int argc, char** argv)
{
    CLI::App app{
        "Measures how well solves meet deadlines (octagonal prism; met: within 20 % or 0.1 ms)"};
    int solves = 200;
    app.add_option("--solves", solves, "solves of each kind")
        ->check(CLI::Range(20, 1000000))
        ->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    const TransducerArray array = TransducerArray::octagonalPrism();
    std::printf("%5s %-5s %9s  %9s %9s %9s  %9s %7s\n",
                "n",
                "start",
                "deadline",
                "ms",
                "worst",
                "kept",
                "rms %",
                "E");
    for (const int n : {50, 200, 800})
    {
        const double build = build_ms(n, array);
        for (const bool warm : {true, false})
            for (const double times : {1.0, 1.5, 2.0, 3.0, 5.0, 10.0})
                race(n, times * build, warm, solves, array);
    }
    return 0;
}
