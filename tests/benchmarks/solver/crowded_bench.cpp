// midair-crowded-bench: fields for points that stand nearer than a wavelength, from nothing and
// while they move. haptics/SOLVER.md quotes it.

#include "haptics/array/TransducerArray.h"
#include "haptics/solvers/HologramSolver.h"
#include "tests/benchmarks/Timing.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <Eigen/Core>

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

struct Scene
{
    std::string name;
    ControlPoints points;
};

std::vector<Scene> scenes()
{
    const double wave_m = Medium().wavelength(40e3);
    return {{"sphere 100, radius 30 mm", spherePoints(100, 0.03)},
            {"sphere 100, radius 15 mm", spherePoints(100, 0.015)},
            {"10 x 10, 4.3 mm", gridPoints(10, 1, 10, 4.3e-3)},
            {"10 x 10, 2.9 mm", gridPoints(10, 1, 10, 2.9e-3)},
            {"20 x 20, wave / 2", gridPoints(20, 1, 20, wave_m / 2)},
            {"20 x 20, wave / 2.9", gridPoints(20, 1, 20, wave_m / 2.9)},
            {"20 on x, wave / 10", gridPoints(20, 1, 1, wave_m / 10)},
            {"20 on y, wave / 3", gridPoints(1, 20, 1, wave_m / 3)}};
}

/// Figures of a series of solves.
struct Tally
{
    std::vector<double> time_ms, rms, loudness, jump;
    double level_Pa = 0.0;

    void add(double ms, const SolveReport& report)
    {
        time_ms.push_back(ms);
        rms.push_back(report.rms);
        loudness.push_back(report.loudness);
        if (level_Pa > 0.0 && report.level_Pa > 0.0)
            jump.push_back(std::max(report.level_Pa / level_Pa, level_Pa / report.level_Pa));
        level_Pa = report.level_Pa;
    }
};

double largest(const std::vector<double>& values)
{
    return values.empty() ? 1.0 : *std::max_element(values.begin(), values.end());
}

void print(const Scene& scene, const std::string& motion, const Tally& tally, bool jumps)
{
    std::printf("%-25s %-9s %8.3f  %9.4f %9.4f  %6.3f %6.3f  ",
                scene.name.c_str(),
                motion.c_str(),
                median(tally.time_ms),
                100.0 * median(tally.rms),
                100.0 * largest(tally.rms),
                *std::min_element(tally.loudness.begin(), tally.loudness.end()),
                largest(tally.loudness));
    if (jumps)
        std::printf("%7.4f\n", largest(tally.jump));
    else
        std::printf("      -\n");
    std::fflush(stdout);
}

/// Moves \a scene along x by \a step_m an update, after one cold solve.
void move(const Scene& scene, double step_m, int updates, const SolverOptions& options)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const auto solver = makeSolver("gauss-newton", options);
    Eigen::VectorXcf q;
    ControlPoints points = scene.points;
    solver->solve(points, array, Medium(), q);
    Tally tally;
    for (int k = 0; k < updates; ++k)
    {
        points.positions.row(0).array() += k % 200 < 100 ? step_m : -step_m;
        const double start = cpu_ms();
        const SolveReport report = solver->solve(points, array, Medium(), q);
        tally.add(cpu_ms() - start, report);
    }
    print(scene, std::to_string(std::lround(1e6 * step_m)) + " um", tally, true);
}

/// Solves \a scene from nothing, turned a little and with another seed each time.
void begin(const Scene& scene, int solves, SolverOptions options)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    options.warmStart = false;
    Tally tally;
    for (int k = 0; k < solves; ++k)
    {
        options.seed = static_cast<std::uint64_t>(k + 1);
        const auto solver = makeSolver("gauss-newton", options);
        ControlPoints points = scene.points;
        points.positions.row(0).array() += 1e-4 * k;
        Eigen::VectorXcf q;
        const double start = cpu_ms();
        const SolveReport report = solver->solve(points, array, Medium(), q);
        tally.add(cpu_ms() - start, report);
    }
    print(scene, "cold", tally, false);
}

} // namespace

int main(int argc, char** argv)
{
    CLI::App app{"Fields for points closer than a wavelength (octagonal prism)"};
    int updates = 300, solves = 20;
    std::string only;
    app.add_option("--updates", updates, "updates of a moving scene")
        ->check(CLI::Range(1, 1000000))
        ->capture_default_str();
    app.add_option("--solves", solves, "cold solves of a scene")
        ->check(CLI::Range(1, 1000000))
        ->capture_default_str();
    app.add_option("--only", only, "scenes whose name contains this");
    CLI11_PARSE(app, argc, argv);

    SolverOptions options;
    options.skipTolerance = 0.0;
    std::printf("%-25s %-9s %8s  %9s %9s  %6s %6s  %7s\n",
                "scene",
                "step",
                "ms",
                "rms %",
                "worst %",
                "E from",
                "to",
                "jump x");
    for (const Scene& scene : scenes())
    {
        if (scene.name.find(only) == std::string::npos) continue;
        begin(scene, solves, options);
        for (const double step_m : {0.0, 1e-5, 1e-4, 1e-3})
            move(scene, step_m, updates, options);
    }
    return 0;
}
