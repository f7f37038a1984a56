#include "tests/benchmarks/solver/Rest.h"

#include "haptics/base/simd/InstructionSet.h"
#include "haptics/points/FittedLevel.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/sequence/FieldOrder.h"
#include "haptics/solvers/ManyStarts.h"
#include "haptics/solvers/Solvers.h"
#include "haptics/solvers/production/GaussNewtonTuning.h"
#include "haptics/solvers/production/LouderPhases.h"
#include "tests/benchmarks/Timing.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>

using namespace midair::haptics;

namespace midair::bench
{

namespace
{

constexpr int kStarts = 20;
constexpr int kStartRounds = 300;

/// Points with their matrix in double precision.
struct Scene
{
    Scene(int n, double radius_m) :
        points(spherePoints(n, radius_m)),
        G(referencePropagationMatrix(points.positions, array, Medium()))
    {
    }

    TransducerArray array = TransducerArray::octagonalPrism();
    ControlPoints points;
    Eigen::MatrixXcd G;
};

/// Figures of a drive as played, without anything that the solver uses.
struct Figures
{
    Figures(const Scene& scene, const Eigen::VectorXcf& q)
    {
        const Eigen::VectorXd y = (scene.G * q.cast<std::complex<double>>()).cwiseAbs();
        const double s = fittedLevel(y, scene.points.targets);
        rms = relativeRms(y, scene.points.targets, s);
        loudness =
            loudnessOf(s, scene.points.targets.norm(), scene.G.cwiseAbs().rowwise().sum().mean());
    }
    double rms = 0.0, loudness = 0.0;
};

void print(const Scene& scene, const std::string& name, double ms, const Figures& figures)
{
    std::printf("%4d  %-34s %8.3f  %7.4f  %6.4f",
                scene.points.size(),
                name.c_str(),
                1e-3 * ms,
                100.0 * figures.rms,
                figures.loudness);
}

void printFromNothing(const Scene& scene, const std::string& name, HologramSolver& solver)
{
    Eigen::VectorXcf q;
    const double start_ms = cpu_ms();
    solver.solve(scene.points, scene.array, Medium(), q);
    print(scene, name, cpu_ms() - start_ms, Figures(scene, q));
    std::printf("\n");
    std::fflush(stdout);
}

/// The largest steps on a walk, and what it passes.
struct Way
{
    int fields = 0;
    double turn_rad = 0.0, largestTurn_rad = 0.0, jump = 1.0, driveChange = 0.0;
    double leastLoudness = 1e9, worstRms = 0.0;
};

// Walks from the last field of \a solver, \a q, to multipliers \a c.
Way walk(const Scene& scene, const Eigen::VectorXcf& c, HologramSolver& solver, Eigen::VectorXcf& q)
{
    Way way;
    PhaseWalk path(solver.multipliers(), c);
    double level_Pa = 0.0;
    while (!path.isOver())
    {
        if (!solver.startFrom(path.next())) break;
        Eigen::VectorXcf next;
        const SolveReport report = solver.solve(scene.points, scene.array, Medium(), next);
        alignField(next, q, scene.array.drive);
        // Of two fields in turn each follows the other, so the step is that of one.
        const CycleSteps step = cycleSteps({q, next});
        const double ratio = level_Pa > 0.0 ? report.level_Pa / level_Pa : 1.0;
        const double jump = std::max(ratio, 1.0 / ratio);
        if (!path.accept(step.meanPhaseStep_rad, jump)) continue;
        ++way.fields;
        way.turn_rad = std::max(way.turn_rad, step.meanPhaseStep_rad);
        way.largestTurn_rad = std::max(way.largestTurn_rad, step.largestPhaseStep_rad);
        way.driveChange = std::max(way.driveChange, step.driveChange);
        way.jump = std::max(way.jump, jump);
        level_Pa = report.level_Pa;
        q = next;
        const Figures figures(scene, q);
        way.leastLoudness = std::min(way.leastLoudness, figures.loudness);
        way.worstRms = std::max(way.worstRms, figures.rms);
    }
    return way;
}

void printAtRest(const Scene& scene)
{
    const auto solver = makeSolver(solverNames().front());
    Eigen::VectorXcf q;
    solver->solve(scene.points, scene.array, Medium(), q);
    LouderPhases phases{SolverOptions()};
    double longest_ms = 0.0;
    const double start_ms = cpu_ms();
    phases.begin(scene.points, scene.array, Medium(), solver->multipliers());
    while (phases.hasWork())
    {
        const double step_ms = cpu_ms();
        phases.step();
        longest_ms = std::max(longest_ms, cpu_ms() - step_ms);
    }
    const double search_ms = cpu_ms() - start_ms;
    const Way way = walk(scene, phases.best(), *solver, q);
    print(scene, "at rest, after the walk", search_ms, Figures(scene, q));
    std::printf("   longest step %.2f ms\n      the walk: %d fields; E at least %.4f, rms at most "
                "%.4f %%; from field to field at most %.4f times the level, %.4f rad a transducer "
                "on average, %.3f rad of any, %.2e of the drive's energy\n",
                longest_ms,
                way.fields,
                way.leastLoudness,
                100.0 * way.worstRms,
                way.jump,
                way.turn_rad,
                way.largestTurn_rad,
                way.driveChange);
    std::fflush(stdout);
}

} // namespace

void printRest()
{
    std::printf("%s, one thread; processor time; figures in double precision\n%4s  %-34s %8s  %7s  "
                "%6s\n",
                base::instructionSetName(base::instructionSet()),
                "n",
                "field",
                "s",
                "rms %",
                "E");
    GaussNewtonTuning longStart;
    longStart.coldStarts = 1;
    longStart.trialRounds = longStart.coldRounds = kStartRounds;
    for (const auto& [n, radius_m] : {std::pair(25, 0.03), {100, 0.03}, {400, 0.06}})
    {
        const Scene scene(n, radius_m);
        for (const std::string& name : solverNames())
            if (name != "greedy") // minutes
                printFromNothing(scene, name, *makeSolver(name));
        ManyStarts many([&](const SolverOptions& options)
                        { return makeGaussNewton(options, longStart); },
                        {},
                        kStarts);
        printFromNothing(scene,
                         "best of " + std::to_string(kStarts) + " starts of " +
                             std::to_string(kStartRounds) + " rounds",
                         many);
        printAtRest(scene);
    }
}

} // namespace midair::bench
