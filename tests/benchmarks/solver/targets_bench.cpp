// midair-targets-bench: fields for targets that differ by up to a thousand, at rest, after jumps,
// while points move and while they fade. haptics/SOLVER.md quotes it.

#include "haptics/array/TransducerArray.h"
#include "haptics/solvers/HologramSolver.h"
#include "tests/benchmarks/Timing.h"
#include "tests/haptics/solvers/UnequalTargets.h"

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

using namespace midair::haptics;
using midair::bench::cpu_ms;
using midair::bench::median;

namespace
{

/// What is asked for on the command line.
struct Choice
{
    std::string array = "octagon", solver = "gauss-newton", only;
    SolverOptions options;
    int moving = 100; // fields
    int points = 100;
    bool verbose = false;
};

double largest(const std::vector<double>& values)
{
    return values.empty() ? 0.0 : *std::max_element(values.begin(), values.end());
}

/// Figures of the fields of one case.
struct Tally
{
    std::vector<double> loud, middle, rms, ofLargest, time_ms, iterations, loudness;

    void add(const TargetErrors& errors, const SolveReport& report, double ms)
    {
        loud.push_back(errors.loud);
        middle.push_back(errors.middle);
        rms.push_back(errors.rms);
        ofLargest.push_back(errors.ofLargest);
        time_ms.push_back(ms);
        iterations.push_back(report.iterations);
        loudness.push_back(report.loudness);
    }
    void print(const std::string& name) const
    {
        std::printf("%-32s %9.4f %9.4f %9.4f %9.4f %9.4f  %7.2f %5.1f %6.3f\n",
                    name.c_str(),
                    100.0 * largest(loud),
                    100.0 * largest(middle),
                    100.0 * median(ofLargest),
                    100.0 * largest(ofLargest),
                    100.0 * median(rms),
                    median(time_ms),
                    median(iterations),
                    median(loudness));
        std::fflush(stdout);
    }
};

/// Where points are put: the middle of an array around them, 150 mm above one that looks one way.
Eigen::Vector3d placeFor(const TransducerArray& array)
{
    const Eigen::Vector3d normal = array.normals.rowwise().mean();
    if (normal.norm() < 0.5) return Eigen::Vector3d::Zero();
    return array.positions.rowwise().mean() + 0.15 * normal;
}

/// Runs \a of and prints the figures of the fields from \a first on. Of moving ones time is that of
/// an update, of others that of the first field for new targets.
void measure(const Choice& choice, const TargetsCase& of, int first)
{
    if (of.name.find(choice.only) == std::string::npos) return;
    const TransducerArray array = TransducerArray::load(choice.array);
    const auto solver = makeSolver(choice.solver, choice.options);
    Tally tally;
    Eigen::VectorXcf q;
    Eigen::MatrixXcd G;
    Eigen::Matrix3Xd places;
    for (int k = 0; k < of.fields; ++k)
    {
        ControlPoints points = of.points(k);
        points.positions.colwise() += placeFor(array);
        const double start = cpu_ms();
        const SolveReport report = solver->solve(points, array, Medium(), q);
        const double ms = cpu_ms() - start;
        if (places.cols() != points.size() || places != points.positions)
        {
            places = points.positions;
            G = referencePropagationMatrix(places, array, Medium());
        }
        const TargetErrors errors = errorsAt(points, G, array, q);
        if (choice.verbose)
            std::printf("  %3d: loud %.4f middle %.4f rms %.4f of largest %.4f  it %d  %.2f ms  E "
                        "%.3f %s; %s\n",
                        k,
                        100 * errors.loud,
                        100 * errors.middle,
                        100 * errors.rms,
                        100 * errors.ofLargest,
                        report.iterations,
                        ms,
                        report.loudness,
                        stopReasonName(report.stop),
                        report.message.c_str());
        if (k >= first) tally.add(errors, report, ms);
    }
    tally.print(of.name);
}

} // namespace

int main(int argc, char** argv)
{
    Choice choice;
    CLI::App app("Errors where targets differ: recomputed in double from the device's levels.");
    app.add_option("--array", choice.array, "array")->capture_default_str();
    app.add_option("--solver", choice.solver, "solver")->capture_default_str();
    app.add_option("--only", choice.only, "cases with this in their names");
    app.add_option("--fields", choice.moving, "fields of the moving cases")->capture_default_str();
    app.add_option("--n", choice.points, "points, even")->capture_default_str();
    app.add_option("--phase-only", choice.options.phaseOnly, "0 or 1")->capture_default_str();
    app.add_option("--iterations", choice.options.maxIterations, "limit; 0: the method's own");
    app.add_flag("--verbose", choice.verbose, "each field");
    CLI11_PARSE(app, argc, argv);
    try
    {
        std::printf("largest errors in %%: of its own target from 0.3 of the largest, from 0.01; "
                    "over the largest target: median field, worst, median rms\n%-32s %9s %9s %9s "
                    "%9s %9s  %7s %5s %6s\n",
                    "case",
                    "loud",
                    "middle",
                    "largest",
                    "worst",
                    "rms",
                    "ms",
                    "it",
                    "E");
        for (const TargetsCase& of : restCases(choice.points))
            measure(choice, of, of.fields > 4 ? kSettled : 0);
        for (const double ratio : {1.0, 3.0, 10.0, 33.0, 100.0, 1000.0})
            measure(choice, movingCase(choice.points, ratio, choice.moving), 1);
        for (const int n : {10, 25, 200, 400})
            measure(choice, movingCase(n, 33.0, choice.moving), 1);
        for (const bool byFactor : {false, true})
            for (const bool rising : {false, true})
                measure(choice, fadingCase(byFactor, rising), 1);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "midair-targets-bench: %s\n", error.what());
        return 1;
    }
    return 0;
}
