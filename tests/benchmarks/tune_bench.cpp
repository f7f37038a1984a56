// How well a rehearsed tuning finds what the rehearsal hides: transducers' phases, polarity, dead
// ones, the focus, the microphone's place.

#include "haptics/base/Units.h"
#include "haptics/base/threads/SteadyClock.h"
#include "haptics/tuning/TuningFit.h"
#include "tests/haptics/solvers/ScenePoints.h"
#include "tests/haptics/tuning/PlateStage.h"
#include "tests/haptics/tuning/TuningAccuracy.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace
{

using namespace midair;
using namespace midair::haptics;

/// What is measured, and with which conditions.
struct Case
{
    std::string name;
    std::string array;
    TuningMethod method = TuningMethod::SINGLE;
    int places = 1;
    RehearsalOptions hidden;
};

/// The worst of all seeds, and the means.
struct Row
{
    double phase_deg = 0.0, worstPhase_deg = 0.0;
    int reversedWrong = 0, dead = 0, deadFound = 0, deadWrong = 0, alive = 0, refused = 0;
    double focus = 1.0;
    std::vector<Eigen::Vector3d> places_m;
    Eigen::Vector3d expected_m = Eigen::Vector3d::Zero();
    double fit_s = 0.0;
    std::string refusal;
};

// Places 5 cm apart: the middle of the octagon; 15 cm before a board.
Eigen::Matrix3Xd placesFor(const std::string& array, int count)
{
    Eigen::Matrix3Xd places(3, 4);
    places << 0.004, 0.05, -0.02, -0.03, // x
        0.002, -0.01, 0.045, -0.04,      // y
        -0.003, 0.02, -0.035, 0.045;     // z
    places.row(2).array() += array == "board" ? 0.15 : 0.0;
    return places.leftCols(count);
}

Row measure(const Case& what, int seeds)
{
    Row row;
    const TransducerArray array = TransducerArray::load(what.array);
    TuningPlanOptions options;
    options.method = what.method;
    options.places = placesFor(what.array, what.places);
    const TuningPlan plan = makeTuningPlan(array, options);
    for (int seed = 1; seed <= seeds; ++seed)
    {
        RehearsalOptions hidden = what.hidden;
        hidden.seed = static_cast<std::uint32_t>(seed);
        RehearsedInstrument instrument(array, plan, hidden);
        TuningReadings readings;
        readings.areLevels = what.method == TuningMethod::LEVELS;
        readings.values.resize(plan.size());
        for (int k = 0; k < plan.size(); ++k)
            readings.values[k] = instrument.reading(k);
        const double start_s = base::steadySeconds();
        const TuningFit fit = fitTuning(array, plan, readings);
        row.fit_s = std::max(row.fit_s, base::steadySeconds() - start_s);
        if (!fit.usable())
        {
            ++row.refused;
            row.refusal = fit.refusal;
            continue;
        }
        const TuningAccuracy accuracy = accuracyOf(fit, instrument);
        const double phase_deg = base::toDegrees(accuracy.phaseError_rad);
        row.phase_deg += phase_deg / seeds;
        row.worstPhase_deg = std::max(row.worstPhase_deg, phase_deg);
        row.reversedWrong += accuracy.reversedWrong;
        row.dead += accuracy.dead;
        row.deadFound += accuracy.deadFound;
        row.deadWrong += accuracy.deadWrong;
        row.alive += array.size() - accuracy.dead;
        row.focus = std::min(row.focus, accuracy.focus);
        for (Eigen::Index p = 0; p < accuracy.placeErrors_m.cols(); ++p)
            row.places_m.emplace_back(accuracy.placeErrors_m.col(p));
        row.expected_m = row.expected_m.cwiseMax(fit.microphone.placeErrors.rowwise().maxCoeff());
    }
    return row;
}

void print(const Case& what, int seeds)
{
    const Row row = measure(what, seeds);
    Eigen::Vector3d rms = Eigen::Vector3d::Zero();
    double worst = 0.0;
    for (const Eigen::Vector3d& d : row.places_m)
    {
        rms += d.cwiseAbs2() / double(row.places_m.size());
        worst = std::max(worst, d.norm());
    }
    rms = 1e3 * rms.cwiseSqrt();
    std::printf(
        "  %-40s %5.2f %5.2f %5d %4d/%-4d %4d/%-6d %6.4f  %4.2f %4.2f %4.2f %5.2f  %4.2f %4.2f "
        "%4.2f %5.2f\n",
        what.name.c_str(),
        row.phase_deg,
        row.worstPhase_deg,
        row.reversedWrong,
        row.deadFound,
        row.dead,
        row.deadWrong,
        row.alive,
        row.focus,
        rms.x(),
        rms.y(),
        rms.z(),
        1e3 * worst,
        1e3 * row.expected_m.x(),
        1e3 * row.expected_m.y(),
        1e3 * row.expected_m.z(),
        row.fit_s);
    if (row.refused > 0)
        std::printf("    refused %d times: %s\n", row.refused, row.refusal.c_str());
    std::fflush(stdout);
}

void printAll(const std::string& array, int seeds)
{
    std::printf(
        "%s, %d seeds; 15 degrees, half reversed, 1 %% dead, place off by 2 mm rms, 1 K off, "
        "noise -40 dB, reflections -20 dB but where said\n"
        "  %-40s %11s %5s %9s %11s %6s  %20s  %14s %5s\n",
        array.c_str(),
        seeds,
        "",
        "phase/deg",
        "rev.",
        "dead",
        "wrong",
        "focus",
        "place x y z, most/mm",
        "expected/mm",
        "fit/s");
    const auto one = [&](const std::string& name, TuningMethod method, int places, auto change)
    {
        Case what{name, array, method, places, {}};
        change(what.hidden);
        print(what, seeds);
    };
    const auto asIs = [](RehearsalOptions&) {};
    using Method = TuningMethod;
    one("single, 1 place", Method::SINGLE, 1, asIs);
    one("single, 4 places", Method::SINGLE, 4, asIs);
    one("hadamard, 1 place", Method::HADAMARD, 1, asIs);
    one("hadamard, 4 places", Method::HADAMARD, 4, asIs);
    one("levels, 1 place", Method::LEVELS, 1, asIs);
    one("levels, 4 places", Method::LEVELS, 4, asIs);
    const auto five = [](RehearsalOptions& hidden) { hidden.displacement_m = 5e-3; };
    one("single, 1 place, 5 mm off", Method::SINGLE, 1, five);
    one("single, 4 places, 5 mm off", Method::SINGLE, 4, five);
    one("single, 1 place, no reflections",
        Method::SINGLE,
        1,
        [](RehearsalOptions& hidden) { hidden.reflections_dB = -300.0; });
    one("single, 4 places, reflections -10 dB",
        Method::SINGLE,
        4,
        [](RehearsalOptions& hidden) { hidden.reflections_dB = -10.0; });
    const auto noisy = [](RehearsalOptions& hidden)
    {
        hidden.noise_dB = -20.0;
        hidden.reflections_dB = -300.0;
    };
    one("single, 1 place, noise -20 dB, no refl.", Method::SINGLE, 1, noisy);
    one("hadamard, 1 place, noise -20 dB, no refl.", Method::HADAMARD, 1, noisy);
    one("single, 4 places, 30 degrees",
        Method::SINGLE,
        4,
        [](RehearsalOptions& hidden) { hidden.detuning_Hz = 490.0; });
}

/// A plate before a board, found with one microphone: the largest errors of all seeds, and the
/// means.
struct PlateRow
{
    double shift_mm = 0.0, said_mm = 0.0, tilt_deg = 0.0, reflection = 0.0; ///< largest errors
    double before = 0.0, after = 0.0;                       ///< left of the readings
    double uncorrected = 0.0, corrected = 0.0, known = 0.0; ///< rms of a field
    double fit_s = 0.0;
    int refused = 0;
};

PlateRow measurePlate(int places, int seeds)
{
    const ControlPoints points = spherePoints(12, 0.015, {0.0, 0.0, 0.13});
    PlateRow row;
    for (int seed = 1; seed <= seeds; ++seed)
    {
        PlateStage stage(places, static_cast<unsigned>(seed));
        const TuningReadings readings = stage.readings();
        const double start_s = base::steadySeconds();
        const ReflectorFit fit = stage.fit(readings);
        row.fit_s += (base::steadySeconds() - start_s) / seeds;
        row.refused += !fit.usable();
        if (!fit.usable()) continue;
        const Reflector& found = fit.reflector;
        row.shift_mm =
            std::max(row.shift_mm, 1e3 * std::fabs(found.heightOf(stage.plate.position)));
        row.said_mm = std::max(row.said_mm, found.accuracy_mm);
        row.tilt_deg = std::max(row.tilt_deg, tiltBetween(found, stage.plate));
        row.reflection =
            std::max(row.reflection, std::fabs(found.reflection - stage.plate.reflection));
        row.before += fit.before / seeds;
        row.after += fit.after / seeds;
        TransducerArray array = stage.tuned;
        row.uncorrected += stage.errorOf(array, points) / seeds;
        array.reflectors = {found};
        row.corrected += stage.errorOf(array, points) / seeds;
        array.reflectors = {stage.plate};
        row.known += stage.errorOf(array, points) / seeds;
    }
    return row;
}

void printPlates(int seeds)
{
    std::printf(
        "a plate 210 mm before a board, 1 degree and 3.4 mm from its guess, %d seeds; field: "
        "rms error of 12 points, uncorrected, corrected, and with the true plate\n"
        "places  shift/mm  said/mm  tilt/deg  reflection  left without, with  "
        "field, corrected, true plate  fit/s\n",
        seeds);
    for (const int places : {1, 2, 4})
    {
        const PlateRow row = measurePlate(places, seeds);
        std::printf("%6d %9.2f %8.2f %9.3f %11.3f %11.1f %% %4.1f %% %8.2f %% %7.2f %% %7.2f %% "
                    "%8.2f%s\n",
                    places,
                    row.shift_mm,
                    row.said_mm,
                    row.tilt_deg,
                    row.reflection,
                    100.0 * row.before,
                    100.0 * row.after,
                    100.0 * row.uncorrected,
                    100.0 * row.corrected,
                    100.0 * row.known,
                    row.fit_s,
                    row.refused > 0 ? ", some refused" : "");
        std::fflush(stdout);
    }
}

int run(int argc, char** argv)
{
    int seeds = 5;
    std::string only;
    CLI::App app("Tunes simulated arrays with hidden errors and prints the remaining errors. "
                 "phase: mean and worst rms error; rev.: wrong polarity; place: rms and largest "
                 "error; expected: the fit's own standard errors.");
    app.add_option("--seeds", seeds, "how many")->check(CLI::Range(1, 1000))->capture_default_str();
    app.add_option("--array", only, "octagon, board or plate alone");
    CLI11_PARSE(app, argc, argv);
    for (const char* array : {"octagon", "board"})
        if (only.empty() || only == array) printAll(array, seeds);
    if (only.empty() || only == "plate") printPlates(seeds);
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
        std::fprintf(stderr, "midair-tune-bench: %s\n", error.what());
        return 1;
    }
}
