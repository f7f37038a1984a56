// What "accurate" means: a field is solved with the model as it is, and what is played is evaluated
// in double precision where the array and the air differ from the model.
#include "haptics/base/InputError.h"
#include "haptics/base/Percentile.h"
#include "haptics/base/Units.h"
#include "haptics/solvers/HologramSolver.h"
#include "tests/haptics/propagation/ChangedPhysics.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

using namespace midair;
using namespace midair::haptics;

namespace
{

struct Arguments
{
    int points = 100;
    double radius_m = 0.03;
    int draws = 20;
};

/// The field that was solved for, and how loud it is in the model.
struct Scene
{
    TransducerArray array = TransducerArray::octagonalPrism();
    Medium medium;
    ControlPoints points;
    Eigen::VectorXcf q;
    double level_Pa = 0.0;
};

/// Prints rms and largest error and the level of \a fields: of several, the median and the largest
/// rms.
void print(const char* what, const Scene& scene, const std::vector<ChangedField>& fields)
{
    std::vector<double> rms;
    std::vector<double> max;
    std::vector<double> level;
    for (const ChangedField& field : fields)
    {
        rms.push_back(100.0 * field.rms);
        max.push_back(100.0 * field.max);
        level.push_back(100.0 * field.level_Pa / scene.level_Pa);
    }
    char worst[32] = "";
    if (fields.size() > 1)
        std::snprintf(worst, sizeof worst, "  (%.2f)", base::percentile(rms, 1.0));
    std::printf("%-44s %7.2f %8.2f %8.1f%s\n",
                what,
                base::percentile(rms, 0.5),
                base::percentile(max, 0.5),
                base::percentile(level, 0.5),
                worst);
    std::fflush(stdout);
}

/// Returns the level of \a model at 50 degrees from the axis, relative to the axis.
double at50_dB(Directivity model)
{
    return 20.0 * std::log10(directivity(model, std::cos(base::toRadians(50.0))));
}

void printAir(const Scene& scene)
{
    struct Change
    {
        const char* what;
        Medium medium;
    };
    const auto changed = [&](double temperature_C, double humidity)
    {
        Medium medium = scene.medium;
        medium.temperature_C += temperature_C;
        medium.relativeHumidity = humidity;
        return medium;
    };
    const double humidity = scene.medium.relativeHumidity;
    for (const Change& change :
         {Change{"air warmer by 1 degree", changed(1.0, humidity)},
          Change{"air warmer by 5 degrees", changed(5.0, humidity)},
          Change{"relative humidity 20 % in place of 50 %", changed(0.0, 0.2)},
          Change{"relative humidity 80 % in place of 50 %", changed(0.0, 0.8)}})
        print(
            change.what, scene, {changedField(scene.points, scene.array, change.medium, scene.q)});
}

void printArray(const Scene& scene, int draws)
{
    TransducerArray measured = scene.array;
    measured.directivity = Directivity::T4010A1_TABLE; // what shipped boards are solved with
    print("measured directivity in place of harmonics",
          scene,
          {changedField(scene.points, measured, scene.medium, scene.q)});
    struct Change
    {
        const char* what;
        ArraySpread spread;
    };
    for (const Change& change :
         {Change{"gains off by 10 % rms", {0.1, 0.0, 0.0}},
          Change{"phases off by 10 degrees rms", {0.0, 10.0, 0.0}},
          Change{"both", {0.1, 10.0, 0.0}},
          Change{"places off by 0.3 mm rms in x, y and z", {0.0, 0.0, 0.3e-3}}})
    {
        std::vector<ChangedField> fields;
        for (int draw = 1; draw <= draws; ++draw)
            fields.push_back(changedField(
                scene.points,
                spreadArray(scene.array, change.spread, static_cast<std::uint64_t>(draw)),
                scene.medium,
                scene.q));
        print(change.what, scene, fields);
    }
}

} // namespace

int main(int argc, char** argv)
{
    Arguments arguments;
    CLI::App app("Solves for points on a sphere in the octagonal array with the nominal model, and "
                 "prints the quality of the played field when array and air deviate from it.",
                 "midair-uncertainty-bench");
    app.add_option("--n", arguments.points, "Number of control points")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    app.add_option("--radius", arguments.radius_m, "Of the sphere, metres")
        ->check(CLI::Range(1e-3, 0.2))
        ->capture_default_str();
    app.add_option("--draws", arguments.draws, "Random arrays for each spread")
        ->check(CLI::Range(1, 10000))
        ->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    try
    {
        Scene scene;
        scene.points = spherePoints(arguments.points, arguments.radius_m);
        const SolveReport report = makeSolver(solverNames().front())
                                       ->solve(scene.points, scene.array, scene.medium, scene.q);
        if (report.level_Pa <= 0.0) throw base::InputError(report.message);
        const ChangedField same = changedField(scene.points, scene.array, scene.medium, scene.q);
        scene.level_Pa = same.level_Pa;
        std::printf("Sphere of %.0f mm, %d points, solved with the model: level %.0f Pa, E %.3f\n"
                    "of %d random arrays the medians (and the largest rms)\n"
                    "%-44s %7s %8s %8s\n",
                    1e3 * arguments.radius_m,
                    arguments.points,
                    scene.level_Pa,
                    report.loudness,
                    arguments.draws,
                    "played where",
                    "rms %",
                    "max %",
                    "level %");
        print("all is as in the model", scene, {same});
        printArray(scene, arguments.draws);
        printAir(scene);
        std::printf("directivity at 50 degrees: measured %.1f dB, harmonics %.1f dB\n",
                    at50_dB(Directivity::T4010A1_TABLE),
                    at50_dB(Directivity::T4010A1_HARMONICS));
    }
    catch (const base::InputError& error)
    {
        std::fprintf(stderr, "midair-uncertainty-bench: %s\n", error.what());
        return 2;
    }
    return 0;
}
