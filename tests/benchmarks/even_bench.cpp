// midair-even-bench: how fast the fields of a cycle are evened out together on one core: the
// pressure between the points against time; --held: the same of single fields, for many shapes.
// haptics/SOLVER.md quotes it.

#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/propagation/FingertipVibration.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/RingingMean.h"
#include "haptics/propagation/SurfaceStatistics.h"
#include "haptics/sequence/CycleEqualizer.h"
#include "haptics/sequence/SequenceComposer.h"
#include "haptics/surface/ObjReader.h"
#include "haptics/surface/SurfaceSampler.h"
#include "tests/benchmarks/Timing.h"
#include "tests/haptics/sequence/EvenedScenes.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

using namespace midair::haptics;
using midair::bench::cpu_ms;

namespace
{

void print(double passed_ms,
           int passes,
           const SurfaceStatistics& now,
           const SurfaceStatistics& before,
           double longest_ms)
{
    std::printf("%8.0f %6d %8.4f %8.3f %8.3f %8.1f %8.4f %9.2f\n",
                passed_ms,
                passes,
                now.coefficientOfVariation,
                now.percentile1,
                now.mean_Pa / before.mean_Pa,
                now.mean_Pa,
                now.vibration,
                longest_ms);
    std::fflush(stdout);
}

constexpr double kStep_s = 1e-3; // of a field

/// The places of \a fields as the programs choose them. \a spacing: another one; 0: theirs.
ControlPoints
placesFor(const EvenedScene& scene, const ControlPoints& points, int fields, double spacing)
{
    if (spacing > 0.0) return scene.places(points, spacing);
    ControlPoints places;
    for (const double one : placeSpacings(fields))
    {
        places = scene.places(points, one);
        if (places.size() <= kMostPlaces) break;
    }
    return places;
}

// What is felt while the transducers ring from field to field.
SurfaceStatistics rungStatistics(const EvenedScene& scene,
                                 const TransducerArray& array,
                                 const Medium& medium,
                                 const std::vector<Eigen::VectorXcf>& fields)
{
    const auto K = static_cast<int>(fields.size());
    const RingingCourse course =
        ringingCourse(scene.fine, array, medium, fields, kStep_s, feltWaves(K, kStep_s));
    SurfaceStatistics rung =
        statisticsOf(course.mean * radiationPressure(1.0, medium), Eigen::VectorXd());
    rung.vibration = fingertipVibration(fingertipPads(scene.fine), course, K * kStep_s);
    return rung;
}

void run(const EvenedScene& scene, int K, int passes, double loudness)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const Medium medium;
    const auto felt = [&](const std::vector<Eigen::VectorXcf>& fields)
    { return rungStatistics(scene, array, medium, fields); };
    ComposerOptions options;
    options.solverOptions.loudness = loudness;
    midair::base::MessageLog messages;
    double start_ms = cpu_ms();
    const FieldSequence cycle =
        SequenceComposer(options, messages).composeCycle(scene.sets(K), {}, array, medium);
    const double composed_ms = cpu_ms() - start_ms;
    start_ms = cpu_ms();
    const ControlPoints places = placesFor(scene, cycle.points(), K, 0.0);
    const double sampled_ms = cpu_ms() - start_ms;
    const SurfaceStatistics held = felt({cycle.fields.front()});
    std::printf("%s: %d fields of %d points in all, solved for in %.0f ms; %d places, found in "
                "%.0f ms; the first, held: %.1f Pa\n%8s %6s %8s %8s %8s %8s %8s %9s\n",
                scene.name.c_str(),
                K,
                cycle.points().size(),
                composed_ms,
                places.size(),
                sampled_ms,
                held.mean_Pa,
                "ms",
                "passes",
                "cv",
                "1 %",
                "pressure",
                "Pa",
                "vibrates",
                "slice ms");
    const SurfaceStatistics before = felt(cycle.fields);
    print(0.0, 0, before, before, 0.0);
    EvenedCycle evened(passes, 0, options.solverOptions);
    double passed_ms = 0.0, longest_ms = 0.0;
    start_ms = cpu_ms();
    evened.begin(cycle, places, array, medium);
    while (evened.hasWork())
    {
        const double slice_ms = cpu_ms();
        const auto better = evened.step();
        longest_ms = std::max(longest_ms, cpu_ms() - slice_ms);
        if (!better) continue;
        passed_ms += cpu_ms() - start_ms;
        print(passed_ms, evened.equalizer().passes(), felt(better->fields), before, longest_ms);
        start_ms = cpu_ms();
    }
    std::printf("\n");
}

struct Constants
{
    double spacing, raise, calming;
};

/// Each of them in turn is another one, for \a K fields.
std::vector<Constants> constantsFor(int K)
{
    const CycleEqualizerOptions usual;
    const double spacing = placeSpacings(K).front();
    const double raise = K <= kFewFields ? usual.fewRaise : usual.ringingRaise;
    std::vector<Constants> all;
    for (const double other : {0.18, 0.22, 0.25, 0.27, 0.33})
        all.push_back({other, raise, usual.calming});
    for (const double other : {1.0, 1.1, 1.2, 1.3, 1.4, 1.5})
        all.push_back({spacing, other, usual.calming});
    for (const double other : {0.0, 0.1, 0.3, 1.0, 3.0})
        all.push_back({spacing, raise, other});
    return all;
}

// Evens the same cycle out with other constants, to the end.
void runConstants(const EvenedScene& scene, int K, int passes)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const Medium medium;
    midair::base::MessageLog messages;
    const FieldSequence cycle =
        SequenceComposer({}, messages).composeCycle(scene.sets(K), {}, array, medium);
    const auto felt = [&](const std::vector<Eigen::VectorXcf>& fields)
    { return rungStatistics(scene, array, medium, fields); };
    const SurfaceStatistics before = felt(cycle.fields);
    std::printf("%s, %d fields: cv %.4f before\n%8s %7s %7s %8s %8s %8s %8s %8s %8s\n",
                scene.name.c_str(),
                K,
                before.coefficientOfVariation,
                "spacing",
                "raise",
                "calming",
                "places",
                "ms",
                "cv",
                "1 %",
                "pressure",
                "vibrates");
    const bool isFew = K <= kFewFields;
    for (const auto& [spacing, raise, calming] : constantsFor(K))
    {
        CycleEqualizerOptions options;
        options.passes = isFew ? EvenedCycle::kFewPasses * passes / K : passes;
        (isFew ? options.fewRaise : options.ringingRaise) = raise;
        options.calming = calming;
        const ControlPoints places = scene.places(cycle.points(), spacing);
        CycleEqualizer equalizer(options, {});
        const double start_ms = cpu_ms();
        equalizer.begin(places, array, medium, cycle.fields, kStep_s);
        while (equalizer.step())
            continue;
        const double passed_ms = cpu_ms() - start_ms;
        const SurfaceStatistics now = felt(equalizer.fields());
        std::printf("%8.2f %7.2f %7.1f %8d %8.0f %8.4f %8.3f %8.3f %8.4f\n",
                    spacing,
                    raise,
                    calming,
                    places.size(),
                    passed_ms,
                    now.coefficientOfVariation,
                    now.percentile1,
                    now.mean_Pa / before.mean_Pa,
                    now.vibration);
        std::fflush(stdout);
    }
    std::printf("\n");
}

/// The sphere and the star, measured between the places of \a fields in turn.
std::vector<EvenedScene> cycleScenes(int fields)
{
    std::vector<EvenedScene> scenes{evenedSphere(), evenedStar(MIDAIR_ROOT)};
    for (EvenedScene& scene : scenes)
        scene.fine = finePlaces(scene.mesh, fields <= kFewFields);
    return scenes;
}

/// Spheres, the sample star and a flat board, and spot, teapot and fandisk from \a folder.
std::vector<EvenedScene> heldScenes(const std::string& folder)
{
    std::vector<EvenedScene> scenes;
    const auto add = [&scenes](const std::string& name, TriangleMesh mesh)
    {
        scenes.push_back({name, std::move(mesh), EvenedScene::wavelength_m(), {}});
        scenes.back().fine = finePlaces(scenes.back().mesh, true);
    };
    for (const int radius_mm : {20, 25, 30, 35, 40, 45})
        add("sphere " + std::to_string(radius_mm), test::sphere(1e-3 * radius_mm, 5));
    for (const char* name : {"spot", "teapot", "fandisk"})
        if (!folder.empty()) add(name, readObj(folder + "/" + name + ".obj").scaledTo(0.08));
    add("star", evenedStar(MIDAIR_ROOT).mesh);
    add("board", test::box({0.08, 0.06, 0.002}));
    return scenes;
}

void printHeldHead()
{
    std::printf("Pa: mean radiation pressure, cv: its coefficient of variation, 1 %%: its first "
                "percentile over\nthe mean, contrast: on the surface over off it; each before > "
                "after; slice: the longest\n\n%-10s %6s %6s %6s %14s %6s %14s %15s %12s %6s %6s "
                "%5s\n",
                "shape",
                "points",
                "places",
                "ms",
                "Pa",
                "ratio",
                "cv",
                "1 %",
                "contrast",
                "passes",
                "s",
                "slice");
}

// A single field of a shape, evened out to the end.
void runHeld(const EvenedScene& scene, int passes, double raise, double spacing)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const Medium medium;
    midair::base::MessageLog messages;
    double start_ms = cpu_ms();
    const FieldSequence given =
        SequenceComposer({}, messages).compose(0, scene.sets(1).front(), {}, array, medium);
    const double solved_ms = cpu_ms() - start_ms;
    const ControlPoints places = placesFor(scene, given.points(), 1, spacing);
    CycleEqualizerOptions options;
    options.passes = passes;
    options.heldRaise = raise;
    CycleEqualizer equalizer(options, {});
    start_ms = cpu_ms();
    equalizer.begin(places, array, medium, given.fields);
    double longest_ms = 0.0;
    for (bool goesOn = true; goesOn;)
    {
        const double slice_ms = cpu_ms();
        goesOn = equalizer.step();
        longest_ms = std::max(longest_ms, cpu_ms() - slice_ms);
    }
    const double passed_ms = cpu_ms() - start_ms;
    const SurfaceStatistics before = surfaceStatistics(scene.fine, array, medium, given.fields);
    const SurfaceStatistics now = surfaceStatistics(scene.fine, array, medium, equalizer.fields());
    std::printf("%-10s %6d %6d %6.0f %6.1f > %5.1f %6.3f %6.3f > %5.3f %6.4f > %6.4f %5.2f > %4.2f "
                "%6d %6.2f %5.1f\n",
                scene.name.c_str(),
                given.points().size(),
                places.size(),
                solved_ms,
                before.mean_Pa,
                now.mean_Pa,
                now.mean_Pa / before.mean_Pa,
                before.coefficientOfVariation,
                now.coefficientOfVariation,
                before.percentile1,
                now.percentile1,
                before.contrast,
                now.contrast,
                equalizer.passes(),
                1e-3 * passed_ms,
                longest_ms);
    std::fflush(stdout);
}

// A held field that goes on from the last one while its surface moves.
void runMoving(const EvenedScene& sphere, int passes, double step_m)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const Medium medium;
    midair::base::MessageLog messages;
    SequenceComposer composer({}, messages);
    EvenedCycle evened(passes, 0, {});
    Eigen::VectorXcf lastSolved, last;
    std::printf("%s, moved by %g mm from field to field: cv and Pa of the solved field and of the "
                "evened one, mean turn of the phases, s of processor time\n",
                sphere.name.c_str(),
                1e3 * step_m);
    for (int frame = 0; frame < 9; ++frame)
    {
        const EvenedScene scene = movedScene(sphere, step_m * frame);
        const FieldSequence held = composer.compose(0, scene.sets(1).front(), {}, array, medium);
        const ControlPoints places = placesFor(scene, held.points(), 1, 0.0);
        const double start_ms = cpu_ms();
        if (frame == 0)
            evened.begin(held, places, array, medium);
        else
            evened.resume(held, places, array, medium);
        FieldSequence played = held;
        while (evened.hasWork())
            if (auto better = evened.step()) played = std::move(*better);
        const double passed_ms = cpu_ms() - start_ms;
        const SurfaceStatistics before = surfaceStatistics(scene.fine, array, medium, held.fields);
        const SurfaceStatistics now = surfaceStatistics(scene.fine, array, medium, played.fields);
        std::printf("%2d %6.3f %5.1f %5.2f > %6.3f %5.1f %5.2f %6.2f\n",
                    frame,
                    before.coefficientOfVariation,
                    before.mean_Pa,
                    frame > 0 ? meanTurn(lastSolved, held.fields.front()) : 0.0,
                    now.coefficientOfVariation,
                    now.mean_Pa,
                    frame > 0 ? meanTurn(last, played.fields.front()) : 0.0,
                    1e-3 * passed_ms);
        std::fflush(stdout);
        lastSolved = held.fields.front();
        last = played.fields.front();
    }
}

// The same in a live pipeline, twice at rest: how long a new snapshot may have to wait.
void runLive(const EvenedScene& scene, int K, double maxPressure_Pa)
{
    midair::bridge::HologramOptions options;
    options.array = TransducerArray::octagonalPrism();
    options.cycle = K;
    options.maxPressure = maxPressure_Pa;
    midair::bridge::HologramPipeline pipeline(options);
    midair::bridge::SceneSnapshot snapshot;
    midair::bridge::HapticObject& object = snapshot.objects.emplace_back();
    object.id = object.meshId = 1;
    object.mesh = std::make_shared<TriangleMesh>(scene.mesh);
    object.properties.spacing_m = scene.spacing_m;
    std::printf("%s, live%s\n%8s %8s %8s %8s %10s\n",
                scene.name.c_str(),
                maxPressure_Pa > 0.0 ? ", under a cap" : "",
                "rest",
                "ms",
                "played",
                "wait ms",
                "playing ms");
    for (const int rest : {1, 2})
    {
        object.pose.translation().x() = 1e-3 * rest;
        pipeline.process(snapshot);
        const double start_ms = cpu_ms();
        int played = 0;
        double wait_ms = 0.0, playing_ms = 0.0;
        while (pipeline.rest_s() == 0.0)
        {
            const double step_ms = cpu_ms();
            const auto result = pipeline.attend();
            const double passed_ms = cpu_ms() - step_ms;
            if (result) ++played;
            (result ? playing_ms : wait_ms) = std::max(result ? playing_ms : wait_ms, passed_ms);
        }
        std::printf(
            "%8d %8.0f %8d %8.1f %10.1f\n", rest, cpu_ms() - start_ms, played, wait_ms, playing_ms);
    }
    std::printf("\n");
}

int run(int argc, char** argv)
{
    CLI::App app("Measures how fast the fields of a cycle are evened out, on one core");
    std::vector<int> cycles{8};
    int passes = ComposerOptions().even;
    double loudness = 1.0;
    app.add_option("--cycle", cycles, "fields in turn");
    app.add_option("--even", passes, "passes");
    app.add_option("--loudness", loudness, "of the fields before");
    bool constants = false;
    app.add_flag("--constants", constants, "other spacings and goals in place of the time's curve");
    bool live = false;
    app.add_flag("--live", live, "steps of a live pipeline in place of the time's curve");
    bool held = false;
    app.add_flag("--held", held, "a single field of each of many shapes");
    std::vector<double> moving_mm;
    app.add_option("--moving", moving_mm, "a single field of a sphere that moves by so many mm");
    std::string meshes;
    app.add_option(
        "--meshes", meshes, "folder of spot.obj, teapot.obj and fandisk.obj, for --held");
    double raise = CycleEqualizerOptions().heldRaise, spacing = 0.0;
    app.add_option("--raise", raise, "goal over the mean before, for --held");
    app.add_option("--spacing", spacing, "of the places, wavelengths, for --held; 0: as played");
    std::string shape;
    app.add_option("--shape", shape, "only the shape of this name, for --held");
    CLI11_PARSE(app, argc, argv);
    if (held)
    {
        printHeldHead();
        for (const EvenedScene& scene : heldScenes(meshes))
            if (shape.empty() || scene.name == shape)
                runHeld(scene, EvenedCycle::kFewPasses * passes, raise, spacing);
        return 0;
    }
    if (!moving_mm.empty())
    {
        for (const double step_mm : moving_mm)
            runMoving(evenedSphere(), passes, 1e-3 * step_mm);
        return 0;
    }
    std::printf(
        "cv: coefficient of variation of the mean radiation pressure over the surface, 1 %%:"
        " its first\npercentile over the mean, pressure: the mean over that before, vibrates: "
        "under a\nfingertip, slice: the longest so far\n\n");
    for (const int K : cycles)
        for (const EvenedScene& scene : cycleScenes(K))
            if (constants)
                runConstants(scene, K, passes);
            else if (live)
                for (const double cap_Pa : {0.0, 2000.0})
                    runLive(scene, K, cap_Pa);
            else
                run(scene, K, passes, loudness);
    return 0;
}

} // namespace

int main(int argc, char** argv)
{
    try
    {
        return run(argc, argv);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "midair-even-bench: %s\n", error.what());
        return 1;
    }
}
