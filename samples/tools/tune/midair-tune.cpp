// midair-tune: finds the phase and gain of each transducer of an array, and where a plate reflects
// its sound, with one microphone.
#include "device/ArrayDevice.h"
#include "device/autd3/emulator/RehearsedAutd3.h"
#include "engine-bridge/display/Display.h"
#include "haptics/array/Reflector.h"
#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Quantity.h"
#include "haptics/base/text/Words.h"
#include "haptics/tuning/FocusCheck.h"
#include "haptics/tuning/ReflectorFit.h"
#include "haptics/tuning/RehearsedInstrument.h"
#include "haptics/tuning/TouchedPlate.h"
#include "haptics/tuning/TuningFit.h"
#include "samples/shared/SettingOptions.h"
#include "samples/shared/ToolOptions.h"
#include "samples/shared/views/CurvePlot.h"
#include "samples/shared/views/Signals.h"
#include "samples/tools/tune/TuneRun.h"

#include <Eigen/Core>

#include <cmath>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace
{

using namespace midair;
using namespace midair::samples;

/// Options of the commands of midair-tune.
struct TuneArguments
{
    std::string array = "octagon";
    std::string plan = "plan.csv";
    std::string out;
    std::string method = "single";
    std::vector<double> mic_m; ///< x, y, z of each place
    std::string placesFile;
    int dutyLevel = 255;
    std::string readings = "readings.csv";
    std::string picture;
    std::string truth;
    std::string tuned;
    bool serves = false;
    RunOptions run;
    haptics::TuningFitOptions fit;
    std::string guess;
    haptics::ReflectorFitOptions reflector;
    haptics::RehearsalOptions rehearsal;
};

using base::InputError;

constexpr std::size_t kMostPlanBytes = std::size_t(1) << 30;

std::string textOf(const std::string& path)
{
    return base::readRegularFile(path, kMostPlanBytes, "\"" + path + "\" ");
}

void writeFile(const std::string& path, const std::string& text)
{
    std::ofstream out(path, std::ios::binary);
    out << text;
    out.flush();
    if (!out) throw InputError("\"" + path + "\" can't be written");
}

/// A plan and its file's checksum.
struct ReadPlan
{
    haptics::TuningPlan plan;
    std::string sum;
};

ReadPlan readPlan(const std::string& path)
{
    const std::string text = textOf(path);
    return {haptics::tuningPlanFromCsv(text, path), haptics::planSum(text)};
}

haptics::TuningReadings readReadings(const std::string& path, const ReadPlan& plan)
{
    haptics::TuningReadings readings = haptics::readingsFromCsv(textOf(path), path, plan.plan);
    if (!readings.planSum.empty() && readings.planSum != plan.sum)
        throw InputError(fmt::format(
            "readings \"{}\" are of plan {}, this one is {}", path, readings.planSum, plan.sum));
    return readings;
}

haptics::TuningMethod methodOf(const std::string& name)
{
    std::vector<std::string> known;
    for (const auto method : {haptics::TuningMethod::SINGLE,
                              haptics::TuningMethod::HADAMARD,
                              haptics::TuningMethod::LEVELS,
                              haptics::TuningMethod::FOCUS})
    {
        known.emplace_back(haptics::tuningMethodName(method));
        if (name == known.back()) return method;
    }
    throw InputError(fmt::format("method is \"{}\"; known are {}{}",
                                 name,
                                 fmt::join(known, ", "),
                                 base::didYouMean(name, known)));
}

std::string lineOf(std::complex<double> value, const haptics::TuningPlan& plan)
{
    const std::string real = base::exactNumber(value.real());
    return haptics::needsPhases(plan.method) ? real + "," + base::exactNumber(value.imag()) : real;
}

using haptics::TransducerState;
using nlohmann::json;

std::string stateName(TransducerState state)
{
    switch (state)
    {
    case TransducerState::FINE:
        return "FINE";
    case TransducerState::REVERSED:
        return "REVERSED";
    case TransducerState::DEAD:
        return "DEAD";
    case TransducerState::UNSURE:
    case TransducerState::NOT_MEASURED:
        break;
    }
    return "UNKNOWN";
}

json rowOf(const Eigen::Vector3d& v)
{
    return {v.x(), v.y(), v.z()};
}

// The commands. Each returns an ExitCode and throws base::InputError or device::DeviceError.
int planTuning(const TuneArguments& arguments)
{
    haptics::TuningPlanOptions options;
    options.method = methodOf(arguments.method);
    options.dutyLevel = arguments.dutyLevel;
    options.temperature_C = arguments.fit.prior.temperature_C;
    if (!arguments.placesFile.empty())
        options.places = haptics::placesFromCsv(textOf(arguments.placesFile), arguments.placesFile);
    const Eigen::Index before = options.places.cols();
    const auto more = static_cast<Eigen::Index>(arguments.mic_m.size() / 3);
    options.places.conservativeResize(3, before + more);
    for (Eigen::Index p = 0; p < 3 * more; ++p)
        options.places(p % 3, before + p / 3) = arguments.mic_m[static_cast<std::size_t>(p)];
    if (options.places.cols() == 0)
        throw InputError("the place of the microphone is missing: --mic X Y Z, or --places FILE");
    const haptics::TuningPlan plan =
        haptics::makeTuningPlan(haptics::TransducerArray::load(arguments.array), options);
    const std::string out = arguments.out.empty() ? "plan.csv" : arguments.out;
    writeFile(out, haptics::toCsv(plan));
    std::cout << fmt::format("{} rows for {} place{} written to {}\n",
                             plan.size(),
                             plan.places.cols(),
                             plan.places.cols() == 1 ? "" : "s",
                             out);
    return EXIT_DONE;
}

int runTuning(const TuneArguments& arguments)
{
    const ReadPlan read = readPlan(arguments.plan);
    const haptics::TransducerArray array = haptics::TransducerArray::load(arguments.array);
    if (array.size() != read.plan.transducers)
        throw InputError(
            fmt::format("plan \"{}\" is for {} transducers of array \"{}\", array \"{}\" "
                        "has {}",
                        arguments.plan,
                        read.plan.transducers,
                        read.plan.array,
                        array.name,
                        array.size()));
    RunOptions options = arguments.run;
    if (!arguments.out.empty()) options.out = arguments.out;
    return runPlan(options, read.plan, read.sum, array);
}

/// Draws a fit into \a path (.svg, .png, .pdf): a map of the array, each side seen from its
/// emission side, with phases, reversed and dead transducers, and histograms of phases and gains.
/// Returns an error message, or an empty text.
std::string drawTuning(const haptics::TuningFit& fit, const std::string& path)
{
    const haptics::TransducerArray& array = fit.array;
    json positions = json::array(), normals = json::array(), states = json::array(),
         phases = json::array(), gains = json::array();
    for (int i = 0; i < array.size(); ++i)
    {
        positions.push_back(rowOf(array.positions.col(i)));
        normals.push_back(rowOf(array.normals.col(i)));
        states.push_back(stateName(fit.states[static_cast<std::size_t>(i)]));
        const double phase_deg = base::toDegrees(array.phaseOffset_rad[i]);
        phases.push_back(phase_deg - 180.0 * std::round(phase_deg / 180.0));
        gains.push_back(array.gain[i]);
    }
    const std::size_t fine = fit.of(TransducerState::FINE).size(),
                      reversed = fit.of(TransducerState::REVERSED).size();
    return drawPlot(path,
                    {{"kind", "tuning"},
                     {"title",
                      fmt::format("{}: {} of {} transducers play, {} of them reversed; {} dead",
                                  array.name,
                                  fine + reversed,
                                  array.size(),
                                  reversed,
                                  fit.of(TransducerState::DEAD).size())},
                     {"caption",
                      fmt::format("phases spread {:.1f} degrees (without polarity), gains {:.1f} "
                                  "%; each side is seen from its emission side",
                                  base::toDegrees(fit.phaseSpread_rad),
                                  100.0 * fit.gainSpread)},
                     {"positions_m", positions},
                     {"normals", normals},
                     {"states", states},
                     {"phase_deg", phases},
                     {"gain", gains}});
}

int fitArray(const TuneArguments& arguments)
{
    const ReadPlan read = readPlan(arguments.plan);
    const haptics::TransducerArray array = haptics::TransducerArray::load(arguments.array);
    const haptics::TuningFit fit =
        haptics::fitTuning(array, read.plan, readReadings(arguments.readings, read), arguments.fit);
    std::cout << fit.text();
    if (!fit.usable()) return EXIT_PROBLEM;
    const std::string out = arguments.out.empty() ? "tuned.json" : arguments.out;
    fit.array.save(out);
    const std::string picture = arguments.picture.empty()
                                    ? std::filesystem::path(out).replace_extension(".svg").string()
                                    : arguments.picture;
    std::cout << "written to  " << out << std::endl;
    const std::string problem = drawTuning(fit, picture);
    if (problem.empty())
        std::cout << "picture     " << picture << "\n";
    else
        std::cerr << "midair-tune: " << problem << "\n";
    return EXIT_DONE;
}

/// Returns the places of a file on a plate: touched ones, or the corners of a display.
Eigen::Matrix3Xd placesOnPlate(const std::string& text, const std::string& path, bool isDisplay)
{
    if (!isDisplay) return haptics::placesFromCsv(text, path);
    const bridge::Display display = bridge::readDisplay(text, path);
    Eigen::Matrix3Xd corners(3, 4);
    corners << display.lowerLeft, display.lowerRight, display.upperLeft,
        display.lowerRight + display.upperLeft - display.lowerLeft;
    return corners;
}

/// Returns the one reflector of a JSON file, or the plate that touched places or a display's file
/// say.
haptics::Reflector guessFrom(const std::string& path, const haptics::TransducerArray& array)
{
    const std::string text = textOf(path);
    const bool isTouched = std::filesystem::path(path).extension() == ".csv";
    const bool isDisplay = !isTouched && text.find("\"screen\"") != std::string::npos;
    if (!isTouched && !isDisplay)
    {
        const std::vector<haptics::Reflector> guesses = haptics::reflectorsFromJson(text, path);
        if (guesses.size() == 1) return guesses.front();
        throw InputError(fmt::format("\"{}\" has {} reflectors; --guess needs one, and the array's "
                                     "file has those that are known",
                                     path,
                                     guesses.size()));
    }
    const Eigen::Matrix3Xd places = placesOnPlate(text, path, isDisplay);
    haptics::TouchedPlate plate;
    try
    {
        plate = haptics::TouchedPlate::at(places, array.positions.rowwise().mean());
    }
    catch (const InputError& error)
    {
        throw InputError(fmt::format("\"{}\": {}", path, error.what()));
    }
    std::cout << fmt::format("guess       {} places, {:.2f} mm rms off the plane of a plate of "
                             "{:.0f} x {:.0f} mm\n",
                             places.cols(),
                             1e3 * plate.off_m,
                             1e3 * plate.reflector.size_m.x(),
                             1e3 * plate.reflector.size_m.y());
    return plate.reflector;
}

int fitReflector(const TuneArguments& arguments)
{
    const ReadPlan read = readPlan(arguments.plan);
    const haptics::TransducerArray array = haptics::TransducerArray::load(arguments.array);
    haptics::ReflectorFitOptions options = arguments.reflector;
    options.prior = arguments.fit.prior;
    options.relativeHumidity = arguments.fit.relativeHumidity;
    options.clip = arguments.fit.clip;
    const haptics::ReflectorFit fit = haptics::fitReflector(array,
                                                            read.plan,
                                                            readReadings(arguments.readings, read),
                                                            guessFrom(arguments.guess, array),
                                                            options);
    std::cout << fit.text();
    if (!fit.usable()) return EXIT_PROBLEM;
    const std::string out = arguments.out.empty() ? "reflectors.json" : arguments.out;
    writeFile(out, "{\"reflectors\": " + haptics::reflectorsToJson({fit.reflector}) + "}\n");
    std::cout << "written to  " << out << "\n";
    return EXIT_DONE;
}

int checkArray(const TuneArguments& arguments)
{
    const ReadPlan read = readPlan(arguments.plan);
    const haptics::FocusCheck check =
        haptics::checkFocus(haptics::TransducerArray::load(arguments.array),
                            read.plan,
                            readReadings(arguments.readings, read));
    std::cout << check.text();
    if (check.refusal.empty())
        std::cout << (check.passes()
                          ? "passed      each focus has 0.9 or more of its predicted level\n"
                          : "failed      a focus has less than 0.9 of its predicted level\n");
    return check.passes() ? EXIT_DONE : EXIT_PROBLEM;
}

int rehearse(const TuneArguments& arguments)
{
    const ReadPlan read = readPlan(arguments.plan);
    haptics::RehearsedInstrument instrument(
        haptics::TransducerArray::load(arguments.array), read.plan, arguments.rehearsal);
    if (!arguments.truth.empty()) instrument.truth().save(arguments.truth);
    haptics::TransducerArray tuned;
    if (!arguments.tuned.empty()) tuned = haptics::TransducerArray::load(arguments.tuned);
    const haptics::TransducerArray* foci = arguments.tuned.empty() ? nullptr : &tuned;
    if (read.plan.method == haptics::TuningMethod::FOCUS && foci == nullptr)
        throw InputError("a plan of foci needs the tuned array: --tuned FILE");
    if (!arguments.serves)
    {
        for (int row = 0; row < read.plan.size(); ++row)
            std::cout << lineOf(instrument.reading(row, foci), read.plan) << "\n";
        return EXIT_DONE;
    }
    for (std::string line; std::getline(std::cin, line);)
    {
        const std::vector<std::string> words = base::splitColumns(line);
        int row = -1;
        if (words.empty() || !base::parseWhole(words[0], row) || row < 0 || row >= read.plan.size())
            throw InputError("request \"" + line + "\"; it should begin with a row of the plan");
        std::cout << lineOf(instrument.reading(row, foci), read.plan) << std::endl;
    }
    return EXIT_DONE;
}

CLI::Validator in(const std::string& unit)
{
    return inUnit(unit, base::parseQuantity);
}

void addArray(CLI::App& command, TuneArguments& arguments, const std::string& help)
{
    command.add_option("--array", arguments.array, help)->capture_default_str();
}

void addPlan(CLI::App& command, TuneArguments& arguments)
{
    command.add_option("--plan", arguments.plan, "the plan")->capture_default_str();
}

void addPlanning(CLI::App& command, TuneArguments& arguments)
{
    addArray(command, arguments, "octagon, board, a shipped array's name or a JSON file");
    command
        .add_option("--mic", arguments.mic_m, "X Y Z of the microphone, m, array frame; repeatable")
        ->type_size(3)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command.add_option("--places", arguments.placesFile, "file of microphone places, one per line");
    command
        .add_option("--method",
                    arguments.method,
                    "single, hadamard or levels; focus: for the check afterwards")
        ->capture_default_str();
    command
        .add_option("--duty", arguments.dutyLevel, "duty level of playing transducers, 1 .. 255")
        ->check(CLI::Range(1, 255))
        ->capture_default_str();
    command
        .add_option("--temperature",
                    arguments.fit.prior.temperature_C,
                    "temperature of the air, C, for the method focus")
        ->check(CLI::Range(-40.0, 60.0))
        ->capture_default_str();
    command.add_option("--out", arguments.out, "file for the plan (plan.csv)");
}

void addRunning(CLI::App& command, TuneArguments& arguments)
{
    RunOptions& run = arguments.run;
    addPlan(command, arguments);
    addArray(command, arguments, "the plan's array; for the method focus the tuned array");
    command.add_option("--device", run.device, "which device")->required();
    command
        .add_option(
            "--readings",
            run.readings,
            "source of readings, a line with re,im or a level for each row: - for stdin, a file or "
            "named pipe, or exec:COMMAND, which gets row,x,y,z,seconds on its stdin for each row")
        ->capture_default_str();
    command.add_option("--out",
                       arguments.out,
                       "file for the readings (readings.csv); an existing one is continued");
    command.add_option("--settle", run.settle_s, "delay between playing a row and reading it, s")
        ->transform(in("s"))
        ->check(CLI::Range(0.0, 60.0))
        ->capture_default_str();
    command
        .add_option(
            "--integrate", run.integrate_s, "time that the instrument takes for a reading, s")
        ->transform(in("s"))
        ->check(CLI::Range(0.0, 60.0))
        ->capture_default_str();
    command.add_option("--patience", run.patience_s, "timeout for a row, s")
        ->transform(in("s"))
        ->check(CLI::Range(0.01, 86400.0))
        ->capture_default_str();
    command.add_option("--clip", run.clip, "level at which the microphone clips; 0: not known")
        ->check(CLI::NonNegativeNumber);
    command.add_flag("--free-running",
                     run.isFreeRunning,
                     "the instrument writes by its own clock: drops lines from before a row");
    command.add_flag(
        "--all-places", run.goesToAllPlaces, "continues with the next place without a stop");
    command.add_flag("--anew", run.begins, "reads an incomplete place from its start");
    command.add_flag("--quiet", run.isQuiet, "doesn't print progress");
}

// What the fits of transducers and of a reflector know beforehand.
void addPriors(CLI::App& command, TuneArguments& arguments)
{
    haptics::TuningFitOptions& fit = arguments.fit;
    command
        .add_option("--search", fit.prior.search_m, "largest error of the microphone's place, m")
        ->transform(in("m"))
        ->check(CLI::Range(0.0, 0.05))
        ->capture_default_str();
    command.add_option("--temperature", fit.prior.temperature_C, "C, of the air")
        ->check(CLI::Range(-40.0, 60.0))
        ->capture_default_str();
    command
        .add_option(
            "--temperature-error", fit.prior.temperatureError_C, "error of that temperature, K")
        ->check(CLI::Range(0.0, 50.0))
        ->capture_default_str();
    command.add_option("--clip", fit.clip, "level at which the microphone clips; 0: not known")
        ->check(CLI::NonNegativeNumber);
}

void addFitting(CLI::App& command, TuneArguments& arguments)
{
    haptics::TuningFitOptions& fit = arguments.fit;
    addPlan(command, arguments);
    addArray(command, arguments, "as for the plan");
    command.add_option("--readings", arguments.readings, "the readings")->capture_default_str();
    command.add_option("--out", arguments.out, "array file to write (tuned.json)");
    command.add_option(
        "--picture",
        arguments.picture,
        "picture to write: .svg, .png or .pdf (default: beside the array file, .svg)");
    addPriors(command, arguments);
    command.add_option("--dead", fit.deadGain, "gain below which a transducer counts as dead")
        ->check(CLI::Range(0.01, 0.5))
        ->capture_default_str();
}

void addReflecting(CLI::App& command, TuneArguments& arguments)
{
    addPlan(command, arguments);
    addArray(command, arguments, "the tuned array");
    command.add_option("--readings", arguments.readings, "the readings, with the reflector there")
        ->capture_default_str();
    command
        .add_option(
            "--guess",
            arguments.guess,
            "file with one reflector, where it is roughly, as for midair-solve --reflectors; a "
            ".csv file with places on it that were touched, x,y,z in metres, its four corners "
            "among them; or the file of a display, for its screen")
        ->required();
    command.add_option("--out", arguments.out, "file to write (reflectors.json)");
    command
        .add_option("--distance",
                    arguments.reflector.search_m,
                    "largest error of the guess along its normal, m")
        ->transform(in("m"))
        ->check(CLI::Range(0.0, 0.02))
        ->capture_default_str();
    command.add_option("--tilt", arguments.reflector.tilt_rad, "largest tilt from the guess, rad")
        ->transform(in("rad"))
        ->check(CLI::Range(0.0, 0.1))
        ->capture_default_str();
    command
        .add_option("--phase-error",
                    arguments.reflector.phaseError_rad,
                    "error of the guessed reflectionPhase_rad, rad; smooth, hard plates turn "
                    "the phase little")
        ->transform(in("rad"))
        ->check(CLI::Range(0.0, 3.2))
        ->capture_default_str();
    addPriors(command, arguments);
}

void addChecking(CLI::App& command, TuneArguments& arguments)
{
    addPlan(command, arguments);
    addArray(command, arguments, "the tuned array");
    command.add_option("--readings", arguments.readings, "the readings")->capture_default_str();
}

void addRehearsing(CLI::App& command, TuneArguments& arguments)
{
    haptics::RehearsalOptions& hidden = arguments.rehearsal;
    addPlan(command, arguments);
    addArray(command, arguments, "the plan's array; for the method focus the array before tuning");
    command.add_option("--tuned", arguments.tuned, "the tuned array, for the method focus");
    command.add_flag("--serve", arguments.serves, "answers requests on stdin, for exec:");
    command.add_option("--truth", arguments.truth, "writes the hidden array to this file");
    command.add_option("--seed", hidden.seed, "random seed")->capture_default_str();
    command.add_option("--detuning", hidden.detuning_Hz, "detuning, Hz rms")->capture_default_str();
    command.add_option("--reversed", hidden.reversed, "share of reversed transducers")
        ->capture_default_str();
    command.add_option("--dead", hidden.dead, "share of dead transducers")->capture_default_str();
    command.add_option("--gain-spread", hidden.gainSpread, "spread of gains, apart from detuning")
        ->capture_default_str();
    command
        .add_option("--place-error", hidden.placeError_m, "error of the microphone's place, m rms")
        ->transform(in("m"))
        ->capture_default_str();
    command.add_option("--temperature", hidden.temperature_C, "C, of the air")
        ->capture_default_str();
    command.add_option("--noise", hidden.noise_dB, "noise relative to one transducer, dB")
        ->capture_default_str();
    command
        .add_option(
            "--reflections", hidden.reflections_dB, "reflections relative to direct sound, dB")
        ->capture_default_str();
    command.add_option("--clip", hidden.clip, "Pa at which the microphone clips; 0: never")
        ->capture_default_str();
    command
        .add_option("--sensitivity", hidden.sensitivity, "sensitivity of the microphone, units/Pa")
        ->capture_default_str();
}

int run(int argc, char** argv)
{
    device::registerRehearsedAutd3();
    TuneArguments arguments;
    CLI::App app("Finds the phase and gain of each transducer of an array, and where a plate "
                 "reflects its sound, with one microphone.\n"
                 "Example: midair-tune plan --mic 0 0 0.15; midair-tune run --device usb: "
                 "--readings -; midair-tune fit\n"
                 "Then plan --method focus, run and check test the result. rehearse simulates an "
                 "instrument with hidden errors.\n"
                 "Exit code: 0 done, 1 more to do (run: repeat the command to continue) or refused "
                 "(fit, reflector, check), 2 wrong input, 3 the device failed.",
                 "midair-tune");
    app.require_subcommand(1);
    int (*chosen)(const TuneArguments&) = nullptr;
    const auto command = [&](const char* name,
                             const char* help,
                             void (*add)(CLI::App&, TuneArguments&),
                             int (*run)(const TuneArguments&))
    {
        CLI::App* sub = app.add_subcommand(name, help);
        add(*sub, arguments);
        sub->callback([&chosen, run] { chosen = run; });
    };
    command("plan", "writes the plan of rows to play", addPlanning, planTuning);
    command("run", "plays the plan and takes the readings", addRunning, runTuning);
    command("fit", "computes the array file from the readings", addFitting, fitArray);
    command("reflector",
            "finds place and reflection of a flat plate with a tuned array",
            addReflecting,
            fitReflector);
    command("check",
            "compares foci of the tuned array with their predicted levels",
            addChecking,
            checkArray);
    command("rehearse",
            "prints readings of a simulated array with hidden errors",
            addRehearsing,
            rehearse);
    int status = EXIT_DONE;
    if (!parseTool(app, argc, argv, status)) return status;
    catchStopSignals();
    std::signal(SIGPIPE, SIG_IGN);
    try
    {
        return chosen(arguments);
    }
    catch (const device::DeviceError& error)
    {
        std::cerr << "midair-tune: " << error.what() << "\n";
        return EXIT_DEVICE;
    }
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
        std::fprintf(stderr, "midair-tune: %s\n", error.what());
        return midair::samples::EXIT_WRONG;
    }
}
