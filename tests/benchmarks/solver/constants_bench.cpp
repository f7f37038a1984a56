// midair-constants-bench: what each constant of the production solver is good for. Each is set to
// other values, one at a time; both solvers then solve the same points in turn, and the table says
// what became of time, error and loudness. haptics/SOLVER.md quotes it.

#include "haptics/array/TransducerArray.h"
#include "haptics/solvers/production/GaussNewtonTuning.h"
#include "tests/benchmarks/Timing.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

using namespace midair::haptics;
using midair::bench::cpu_ms;
using midair::bench::median;

namespace
{

/// A series of solves that all constants are tried on.
struct Scene
{
    const char* name;
    int points;
    double radius_m;
    int solves;
    bool cold = false;      ///< every solve starts from nothing
    double pressure_Pa = 0; ///< over 0: targets in Pa
    bool phaseOnly = true;
    double jump_m = 1e-3; ///< from one solve to the next
};

constexpr Scene kScenes[] = {
    {"moving 25", 25, 0.03, 400},
    {"moving 100", 100, 0.03, 400},
    {"moving 400", 400, 0.06, 100},
    {"crowded 100", 100, 0.015, 200},
    {"leaping 100", 100, 0.03, 200, false, 0, true, 2e-2},
    {"cold 100", 100, 0.03, 40, true},
    {"400 Pa 100", 100, 0.03, 200, false, 400.0},
    {"400 Pa, amplitudes 100", 100, 0.03, 200, false, 400.0, false},
};

struct Variant
{
    const char* constant;
    double value;
    std::function<void(GaussNewtonTuning&, double)> set;
};

template<class T>
void add(std::vector<Variant>& all,
         const char* name,
         T GaussNewtonTuning::*member,
         std::initializer_list<double> values)
{
    for (const double value : values)
        all.push_back({name, value, [member](GaussNewtonTuning& tuning, double v) {
                           tuning.*member = static_cast<T>(v);
                       }});
}

void addEffort(std::vector<Variant>& all,
               const char* name,
               const std::function<void(GaussNewtonTuning&, double)>& set,
               std::initializer_list<double> values)
{
    for (const double value : values)
        all.push_back({name, value, set});
}

std::vector<Variant> variants()
{
    using T = GaussNewtonTuning;
    std::vector<Variant> all;
    add(all, "mostReweighing", &T::mostReweighing, {2, 20});
    add(all, "coldStarts", &T::coldStarts, {1, 2, 6});
    add(all, "trialRounds", &T::trialRounds, {5, 20});
    add(all, "coldRounds", &T::coldRounds, {15, 60});
    add(all, "roundsBeforeWeights", &T::roundsBeforeWeights, {0, 8});
    add(all, "quietRounds", &T::quietRounds, {0, 1, 5});
    add(all, "quiet", &T::quiet, {0.9, 0.99, 1.0});
    add(all, "forget", &T::forget, {0.998, 1.0});
    add(all, "lost", &T::lost, {0.0, 0.95, 0.985});
    add(all, "largestTurn_rad", &T::largestTurn_rad, {0.2, 0.5, 2.0});
    add(all, "mostFreedom", &T::mostFreedom, {2, 8, 1e6});
    add(all, "corrections", &T::corrections, {1, 4, 16});
    add(all, "conjugateSteps", &T::conjugateSteps, {6, 24});
    add(all, "searchAbove", &T::searchAbove, {0.03, 0.3, 1e9});
    add(all, "searchApart", &T::searchApart, {0.1, 0.2, 1e9});
    add(all, "crowded", &T::crowded, {0.4, 1.0});
    add(all, "leastOfWeight", &T::leastOfWeight, {0.002, 0.2});
    add(all, "roundingMargin", &T::roundingMargin, {1.0, 2.0});
    add(all, "farTolerance", &T::farTolerance, {0.2, 0.8});
    add(all, "nextTolerance", &T::nextTolerance, {0.1, 1.0});
    add(all, "lastTolerance", &T::lastTolerance, {0.2, 0.9});
    add(all, "shapePasses", &T::shapePasses, {1, 6});
    add(all, "shapeable", &T::shapeable, {0.3, 1.3});
    add(all, "levelMargin", &T::levelMargin, {1e-5, 1e-3});
    addEffort(all,
              "quick.share",
              [](T& t, double v) { t.quick.share = static_cast<float>(v); },
              {0, 0.125, 0.5, 1});
    add(all, "leastPerPoint", &T::leastPerPoint, {0.0, 5.0});
    add(all, "mostPerPoint", &T::mostPerPoint, {10.0, 1e9});
    addEffort(all,
              "quick.passes",
              [](T& t, double v) { t.quick.passes = static_cast<int>(v); },
              {1, 2, 5});
    addEffort(all,
              "quick.reach",
              [](T& t, double v) { t.quick.reach = static_cast<float>(v); },
              {0.5, 1.5});
    addEffort(all,
              "thorough.share",
              [](T& t, double v) { t.thorough.share = static_cast<float>(v); },
              {0, 0.25});
    addEffort(all,
              "thorough.passes",
              [](T& t, double v) { t.thorough.passes = static_cast<int>(v); },
              {1, 6});
    addEffort(all,
              "thorough.reach",
              [](T& t, double v) { t.thorough.reach = static_cast<float>(v); },
              {0.7, 2.5});
    add(all, "damped", &T::damped, {3, 20});
    add(all, "dampedConjugateSteps", &T::dampedConjugateSteps, {12, 48});
    add(all, "yield", &T::yield, {0.99, 1.0});
    add(all, "recovery", &T::recovery, {1.0, 1.005});
    add(all, "leastKept", &T::leastKept, {0.3, 0.95});
    add(all, "coldDamped", &T::coldDamped, {20, 150});
    add(all, "leastCold", &T::leastCold, {0.3, 0.9});
    return all;
}

/// The sphere of \a scene on its way: steps in turning directions, with 1 degree about a turning
/// axis, within 30 mm of the middle.
ControlPoints pointsAt(const Scene& scene, int k)
{
    const double t = scene.jump_m / 0.03 * k;
    const Eigen::Vector3d place =
        0.03 * Eigen::Vector3d(std::sin(t), std::sin(0.7 * t), std::sin(0.3 * t));
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(M_PI / 180.0 * k,
                          Eigen::Vector3d(std::cos(0.15 * k), std::sin(0.05 * k), 1.0).normalized())
            .toRotationMatrix();
    ControlPoints points = spherePoints(scene.points, scene.radius_m);
    points.positions = (turn * points.positions).eval().colwise() + place;
    points.normals = (turn * points.normals).eval();
    if (scene.pressure_Pa > 0.0)
    {
        points.absolute = true;
        points.targets.setConstant(scene.pressure_Pa);
    }
    return points;
}

/// What one solver made of a scene.
struct Tally
{
    std::vector<double> time_ms, rms, loudness;
    double iterations = 0.0;

    void add(double ms, const SolveReport& report)
    {
        time_ms.push_back(ms);
        rms.push_back(report.rms);
        loudness.push_back(report.loudness);
        iterations += report.iterations;
    }
};

double mean(const std::vector<double>& values)
{
    double sum = 0.0;
    for (const double value : values)
        sum += value;
    return sum / static_cast<double>(values.size());
}

void print(const char* constant,
           const std::string& value,
           const Scene& scene,
           const Tally& tally,
           const Tally& own)
{
    const auto solves = static_cast<double>(tally.rms.size());
    std::printf("%-31s %8s  %-23s %6.3f  %8.4f %9.4f  %7.4f %7.4f  %5.2f\n",
                constant,
                value.c_str(),
                scene.name,
                mean(tally.time_ms) / mean(own.time_ms),
                100.0 * median(tally.rms),
                100.0 * *std::max_element(tally.rms.begin(), tally.rms.end()),
                mean(tally.loudness),
                *std::min_element(tally.loudness.begin(), tally.loudness.end()),
                tally.iterations / solves);
}

/// Solves \a scene with the solver's own constants and with \a tuning in turn. True if any field
/// differs.
bool race(const Scene& scene, const GaussNewtonTuning& tuning, Tally& own, Tally& other)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    SolverOptions options;
    options.warmStart = !scene.cold;
    options.phaseOnly = scene.phaseOnly;
    options.skipTolerance = 0.0;
    const std::unique_ptr<HologramSolver> solvers[] = {makeGaussNewton(options, {}),
                                                       makeGaussNewton(options, tuning)};
    Eigen::VectorXcf q[2];
    bool differs = false;
    for (int k = 0; k < scene.solves; ++k)
    {
        const ControlPoints points = pointsAt(scene, k);
        for (int turn = 0; turn < 2; ++turn)
        {
            const int s = (turn + k) % 2;
            const double start = cpu_ms();
            const SolveReport report = solvers[s]->solve(points, array, Medium(), q[s]);
            const double took = cpu_ms() - start;
            if (report.stop == StopReason::REFUSED) throw std::runtime_error(report.message);
            if (k == 0 && !scene.cold) continue; // the first field of a warm solver is cold
            (s == 0 ? own : other).add(took, report);
        }
        differs = differs || q[0] != q[1];
    }
    return differs;
}

} // namespace

int main(int argc, char** argv)
{
    CLI::App app("Varies each constant of the production solver and prints the effect. A constant "
                 "that changes no field of a scene is not listed for it.");
    std::string only;
    app.add_option("--only", only, "the constant to vary; all without it");
    CLI11_PARSE(app, argc, argv);

    std::printf("%-31s %8s  %-23s %6s  %8s %9s  %7s %7s  %5s\n",
                "constant",
                "value",
                "scene",
                "time",
                "rms %",
                "worst %",
                "E",
                "least E",
                "it");
    for (const Scene& scene : kScenes)
    {
        Tally own, same;
        race(scene, {}, own, same);
        print("(all as they are)", "", scene, same, own);
    }
    bool found = only.empty();
    for (const Variant& variant : variants())
    {
        if (!only.empty() && std::string(variant.constant).rfind(only, 0) != 0) continue;
        found = true;
        GaussNewtonTuning tuning;
        variant.set(tuning, variant.value);
        for (const Scene& scene : kScenes)
        {
            Tally own, other;
            if (!race(scene, tuning, own, other)) continue;
            char value[32];
            std::snprintf(value, sizeof value, "%g", variant.value);
            print(variant.constant, value, scene, other, own);
        }
        std::fflush(stdout);
    }
    if (!found)
        std::fprintf(stderr, "midair-constants-bench: no constant is called '%s'\n", only.c_str());
    return found ? 0 : 1;
}
