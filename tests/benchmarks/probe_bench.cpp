// midair-probe-bench: what ringing transducers make of fields in turn, beside the steady fields,
// and how long the probe and the means take on one core. ACCURACY.md quotes the tables.

#include "haptics/probe/PressureProbe.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/RingingMean.h"
#include "haptics/propagation/SurfaceStatistics.h"
#include "haptics/sequence/FieldOrder.h"
#include "haptics/sequence/SequenceComposer.h"
#include "tests/benchmarks/Timing.h"
#include "tests/haptics/sequence/EvenedScenes.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <functional>
#include <random>
#include <string>

#include <CLI/CLI.hpp>

using namespace midair::haptics;
using midair::bench::cpu_ms;

namespace
{

struct Setup
{
    TransducerArray array = TransducerArray::octagonalPrism();
    Medium medium;
};

ControlPoints allOf(const std::vector<ControlPoints>& sets)
{
    ControlPoints all = sets.front();
    for (std::size_t k = 1; k < sets.size(); ++k)
        append(all, sets[k]);
    return all;
}

FieldSequence composed(const EvenedScene& scene,
                       int K,
                       const std::function<void(ComposerOptions&)>& choose,
                       const Setup& setup)
{
    ComposerOptions options;
    options.even = 0;
    choose(options);
    midair::base::MessageLog messages;
    SequenceComposer composer(options, messages);
    const std::vector<ControlPoints> sets = scene.sets(K);
    if (K == 1) return composer.compose(0, sets.front(), {}, setup.array, setup.medium);
    ControlPoints places;
    if (options.even > 0) places = scene.places(allOf(sets));
    return composer.composeCycle(sets, places, setup.array, setup.medium);
}

void printHead(const std::string& name)
{
    std::printf("%s\n%-34s %7s %7s %7s %6s %6s %6s %6s %6s %6s\n",
                name.c_str(),
                "",
                "Pa",
                "ringing",
                "ratio",
                "cv",
                "ring.",
                "1 %",
                "ring.",
                "power",
                "AM");
}

void printRow(const std::string& name,
              const EvenedScene& scene,
              const FieldSequence& sequence,
              const Setup& setup)
{
    const SurfaceStatistics steady = statisticsOf(
        meanRadiationPressure(scene.fine, setup.array, setup.medium, sequence.fields), {});
    const SurfaceStatistics ringing =
        statisticsOf(ringingMeanSquare(scene.fine,
                                       setup.array,
                                       setup.medium,
                                       sequence.fields,
                                       1.0 / sequence.modulation.fieldRate_Hz) *
                         radiationPressure(1.0, setup.medium),
                     {});
    std::printf("%-34s %7.1f %7.1f %7.3f %6.3f %6.3f %6.3f %6.3f %6.3f %6.3f\n",
                name.c_str(),
                steady.mean_Pa,
                ringing.mean_Pa,
                ringing.mean_Pa / steady.mean_Pa,
                steady.coefficientOfVariation,
                ringing.coefficientOfVariation,
                steady.percentile1,
                ringing.percentile1,
                sequence.report.ringingShare,
                sequence.report.ringingModulation);
    std::fflush(stdout);
}

// The same fields with common phases drawn by chance, or in an order drawn by chance and aligned.
FieldSequence byChance(FieldSequence sequence, bool order, const Setup& setup)
{
    std::mt19937 random(1);
    if (order)
    {
        std::shuffle(sequence.fields.begin(), sequence.fields.end(), random);
        alignFields(sequence.fields, setup.array.drive);
    }
    else
        for (Eigen::VectorXcf& q : sequence.fields)
            q *= std::polar(1.0f, std::uniform_real_distribution<float>(0.0f, 6.2831853f)(random));
    rateRinging(sequence, setup.array.ringing_s);
    return sequence;
}

void runScene(const EvenedScene& scene, const Setup& setup)
{
    printHead(scene.name);
    const auto none = [](ComposerOptions&) {};
    const auto row = [&](const std::string& name, int K, const auto& choose)
    {
        FieldSequence sequence = composed(scene, K, choose, setup);
        printRow(name, scene, sequence, setup);
        return sequence;
    };
    row("one field", 1, none);
    row("AM of 200 Hz", 1, [](ComposerOptions& o) { o.modulation.amplitudeRate_Hz = 200.0; });
    const FieldSequence cycle = row("cycle of 8", 8, none);
    row("cycle of 8, evened", 8, [](ComposerOptions& o) { o.even = 25; });
    row("evened, 100 passes", 8, [](ComposerOptions& o) { o.even = 100; });
    // By fields that know nothing of ringing.
    Setup steady = setup;
    steady.array.ringing_s = 0.0;
    FieldSequence blind = composed(
        scene, 8, [](ComposerOptions& o) { o.even = 25; }, steady);
    rateRinging(blind, setup.array.ringing_s);
    printRow("evened as steady fields", scene, blind, setup);
    row("cycle of 8, 3 steps between", 8, [](ComposerOptions& o) { o.cycleSteps = 3; });
    row("evened, 3 steps between",
        8,
        [](ComposerOptions& o)
        {
            o.even = 25;
            o.cycleSteps = 3;
        });
    row("4 subsets", 1, [](ComposerOptions& o) { o.subsets = 4; });
    printRow("cycle of 8, phases by chance", scene, byChance(cycle, false, setup), setup);
    printRow("cycle of 8, order by chance", scene, byChance(cycle, true, setup), setup);
    for (const double rate_Hz : {250.0, 500.0, 2000.0})
    {
        const std::string at = " at " + std::to_string(static_cast<int>(rate_Hz)) + "/s";
        const auto choose = [rate_Hz](ComposerOptions& o) { o.fieldRate = rate_Hz; };
        row("cycle of 8" + at, 8, choose);
        row("evened" + at,
            8,
            [&](ComposerOptions& o)
            {
                choose(o);
                o.even = 25;
            });
    }
    std::printf("\n");
}

void runTimes(const EvenedScene& scene, const Setup& setup)
{
    const FieldSequence cycle = composed(
        scene, 8, [](ComposerOptions&) {}, setup);
    const double start_ms = cpu_ms();
    const PressureProbe probe(setup.array, setup.medium, stepsOf(cycle, 1.0));
    const ProbeOptions options;
    const Eigen::VectorXcd p_Pa = probe.at({0.03, 0.0, 0.0}, options);
    const double probed_ms = cpu_ms() - start_ms;
    const double mean_ms = cpu_ms();
    const Eigen::Matrix3Xd points = cycle.points().positions;
    ringingMeanSquare(points, setup.array, setup.medium, cycle.fields, 1e-3);
    std::printf("1 s at one point, %d transducers, %d samples, 1000 fields: %.0f ms\n"
                "mean over the cycle, 8 fields, with ringing: %.3f ms a point\n",
                setup.array.size(),
                static_cast<int>(p_Pa.size()),
                probed_ms,
                (cpu_ms() - mean_ms) / static_cast<double>(points.cols()));
    FieldSequence rated = cycle;
    const double rate_ms = cpu_ms();
    rateRinging(rated, setup.array.ringing_s);
    std::printf("ringingShare of 8 fields: %.3f ms\n", cpu_ms() - rate_ms);
}

int run(int argc, char** argv)
{
    CLI::App app("Computes the effect of ringing on fields in turn, and times the computation");
    Setup setup;
    double ringing_us = 1e6 * setup.array.ringing_s;
    bool times = false;
    app.add_option("--ringing", ringing_us, "time constant, us");
    app.add_flag("--times", times, "times alone");
    CLI11_PARSE(app, argc, argv);
    setup.array.ringing_s = 1e-6 * ringing_us;
    if (!times)
    {
        std::printf(
            "%g us; 1000 fields a second where nothing else is said. Pa: mean radiation pressure "
            "over the surface, cv: its\ncoefficient of variation, 1 %%: its first percentile over "
            "the mean, each of the steady fields and with ringing;\npower: what is radiated over "
            "the steady power (ringingShare), AM: swing of a modulation that is left\n\n",
            ringing_us);
        runScene(evenedSphere(), setup);
        runScene(evenedStar(MIDAIR_ROOT), setup);
    }
    runTimes(evenedSphere(), setup);
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
        std::fprintf(stderr, "midair-probe-bench: %s\n", error.what());
        return 1;
    }
}
