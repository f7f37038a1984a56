// How soon a solve ends once it is asked to: each solver with few and many points, a million
// iterations, from the request to the return, in wall time and in time of the thread that solves.
// Then whole scenes with settings that take long, from closing until the thread is gone, and the
// most memory that was used by then.
#include "engine-bridge/pipeline/HologramThread.h"
#include "haptics/base/InputError.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/base/threads/ThreadPool.h"
#include "haptics/solvers/HologramSolver.h"
#include "tests/benchmarks/Timing.h"
#include "tests/engine-bridge/pipeline/Fakes.h"
#include "tests/haptics/solvers/ScenePoints.h"
#include "tests/haptics/surface/SphereMesh.h"

#include <atomic>
#include <chrono>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <sys/resource.h>

using namespace midair::haptics;
using midair::base::percentile;
using midair::bench::cpu_ms;
using midair::bench::median;
using midair::bench::wall_ms;
using midair::bridge::HologramOptions;
using midair::bridge::SceneSnapshot;

namespace
{

struct Ending
{
    double byWall_ms = 0.0, byCpu_ms = 0.0;
};

/// Asked to stop \a after_ms into the solve; solved again where it ended by itself before.
Ending timeStop(const std::string& name, int n, double after_ms, int threads)
{
    midair::base::StopSource source;
    SolverOptions options;
    options.maxIterations = 1000000;
    options.rmsTolerance = 0.0;
    options.skipTolerance = 0.0;
    options.warmStart = false;
    options.threads = threads;
    options.stop = source.token();
    const TransducerArray array = TransducerArray::octagonalPrism();
    const auto solver = makeSolver(name, options);
    const ControlPoints points = spherePoints(n, 0.06);
    std::atomic<double> requested_ms{0.0}, cpuThen_ms{0.0};
    clockid_t clock{};
    pthread_getcpuclockid(pthread_self(), &clock);
    std::thread later(
        [&]
        {
            std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(after_ms));
            cpuThen_ms = cpu_ms(clock);
            requested_ms = wall_ms();
            source.request();
        });
    Eigen::VectorXcf q;
    while (solver->solve(points, array, Medium(), q).stop != StopReason::STOPPED)
    {
    }
    const Ending ending{wall_ms() - requested_ms, cpu_ms(clock) - cpuThen_ms};
    later.join();
    return ending;
}

struct SceneCase
{
    const char* name;
    double radius_m;
    int rings;
    double spacing_m;
    std::function<void(HologramOptions&, midair::bridge::HapticObject&)> set;
};

const std::vector<SceneCase>& sceneCases()
{
    using midair::bridge::HapticObject;
    static const std::vector<SceneCase> cases = {
        {"threads 256 subsets 64",
         0.06,
         20,
         0.006,
         [](HologramOptions& o, HapticObject&)
         {
             o.solverOptions.threads = 256;
             o.subsets = 64;
         }},
        {"sdp-bcd of a million iterations",
         0.06,
         20,
         0.006,
         [](HologramOptions& o, HapticObject&)
         {
             o.solver = "sdp-bcd";
             o.solverOptions.maxIterations = 1000000;
         }},
        {"cycle 64 steps 16 capped",
         0.06,
         20,
         0.006,
         [](HologramOptions& o, HapticObject&)
         {
             o.cycle = 64;
             o.cycleSteps = 16;
             o.maxPressure = 500.0;
         }},
        {"outlines",
         0.05,
         3,
         0.0,
         [](HologramOptions&, HapticObject& object)
         { object.properties.sampling = Sampling::EDGES; }},
        {"monitor",
         0.06,
         20,
         0.006,
         [](HologramOptions& o, HapticObject&) { o.monitorInterval = 0.05; }},
        {"a million points asked for",
         0.07,
         20,
         0.002,
         [](HologramOptions& o, HapticObject&) { o.maxPoints = 1000000; }},
        {"a million triangles", 0.06, 500, 0.006, [](HologramOptions&, HapticObject&) {}},
    };
    return cases;
}

double timeClosing(const SceneCase& scene, double after_ms)
{
    HologramOptions options;
    options.array = TransducerArray::octagonalPrism();
    options.deviceUri = "null:";
    SceneSnapshot snapshot = squareSnapshot();
    midair::bridge::HapticObject& object = snapshot.objects[0];
    object.mesh = sphere(scene.radius_m, scene.rings);
    object.properties.spacing_m = scene.spacing_m;
    scene.set(options, object);
    auto thread = std::make_unique<midair::bridge::HologramThread>(options);
    thread->submit(snapshot);
    std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(after_ms));
    const double start_ms = wall_ms();
    thread.reset();
    return wall_ms() - start_ms;
}

void benchScenes(int repeats, double upTo_ms)
{
    std::printf("\nscene, median ms, worst ms, most memory so far MB\n");
    for (const SceneCase& scene : sceneCases())
    {
        std::vector<double> times;
        for (int k = 0; k < repeats; ++k)
            times.push_back(timeClosing(scene, upTo_ms * (k + 0.5) / repeats));
        rusage usage{};
        getrusage(RUSAGE_SELF, &usage);
        std::printf("%s, %.1f, %.1f, %ld\n",
                    scene.name,
                    median(times),
                    percentile(times, 1.0),
                    usage.ru_maxrss / 1024);
        std::fflush(stdout);
    }
}

} // namespace

int main(int argc, char** argv)
{
    std::vector<std::string> solvers = solverNames();
    std::vector<int> counts = {100, 1000};
    int repeats = 11;
    int threads = 1;
    double upTo_ms = 3000.0;
    CLI::App app("midair-stop-bench: measures the time from a stop request until a solve returns");
    app.add_option("--solvers", solvers)->check(CLI::IsMember(solverNames()));
    app.add_option("--points", counts);
    app.add_option("--repeats", repeats)->check(CLI::Range(1, 10000));
    app.add_option("--threads", threads)->check(CLI::Range(1, 256));
    app.add_option("--up-to", upTo_ms, "ms; requests come evenly spread over so long");
    CLI11_PARSE(app, argc, argv);
    std::printf(
        "solver, points, threads, median wall ms, worst wall ms, median cpu ms, worst cpu ms\n");
    for (const std::string& name : solvers)
        for (const int n : counts)
        {
            std::vector<double> wall, cpu;
            for (int k = 0; k < repeats; ++k)
            {
                const Ending ending = timeStop(name, n, upTo_ms * (k + 0.5) / repeats, threads);
                wall.push_back(ending.byWall_ms);
                cpu.push_back(ending.byCpu_ms);
            }
            std::printf("%s, %d, %d, %.1f, %.1f, %.1f, %.1f\n",
                        name.c_str(),
                        n,
                        threads,
                        median(wall),
                        percentile(wall, 1.0),
                        median(cpu),
                        percentile(cpu, 1.0));
            std::fflush(stdout);
        }
    benchScenes(repeats, upTo_ms);
    return 0;
}
