// midair-tune: finds the phase and gain of each transducer of an array with one microphone.

#include "device/ArrayDevice.h"
#include "device/autd3/emulator/RehearsedAutd3.h"
#include "haptics/base/text/Quantity.h"
#include "samples/shared/SettingOptions.h"
#include "samples/shared/views/Signals.h"
#include "samples/tools/tune/TuneCommands.h"

#include <csignal>
#include <exception>
#include <iostream>

#include <CLI/CLI.hpp>

namespace
{

using namespace midair;
using namespace midair::samples;

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
        .add_option("--mic",
                    arguments.mic_m,
                    "X Y Z where the microphone stands, m, array frame; again for more places")
        ->type_size(3)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command.add_option("--places", arguments.placesFile, "file of such places, a line each");
    command
        .add_option(
            "--method", arguments.method, "single, hadamard or levels; focus: the check afterwards")
        ->capture_default_str();
    command.add_option("--duty", arguments.dutyLevel, "duty level of all that plays, 1 .. 255")
        ->check(CLI::Range(1, 255))
        ->capture_default_str();
    command
        .add_option("--temperature", arguments.fit.prior.temperature_C, "C, for the method focus")
        ->check(CLI::Range(-40.0, 60.0))
        ->capture_default_str();
    command.add_option("--out", arguments.out, "file of the plan (plan.csv)");
}

void addRunning(CLI::App& command, TuneArguments& arguments)
{
    RunOptions& run = arguments.run;
    addPlan(command, arguments);
    addArray(command, arguments, "as for the plan; of the method focus: the tuned one");
    command.add_option("--device", run.device, "which device")->required();
    command
        .add_option("--readings",
                    run.readings,
                    "where readings come from, a line of re,im or of a level for each row: - for "
                    "stdin, a file or named pipe, or exec:COMMAND, which is told row,x,y,z,seconds "
                    "in a line on its stdin")
        ->capture_default_str();
    command.add_option("--out", arguments.out, "file of readings (readings.csv), which goes on");
    command.add_option("--settle", run.settle_s, "s from when a row sounds until it is read")
        ->transform(in("s"))
        ->check(CLI::Range(0.0, 60.0))
        ->capture_default_str();
    command.add_option("--integrate", run.integrate_s, "s that the instrument takes for a reading")
        ->transform(in("s"))
        ->check(CLI::Range(0.0, 60.0))
        ->capture_default_str();
    command.add_option("--patience", run.patience_s, "s that a row may take at most")
        ->transform(in("s"))
        ->check(CLI::Range(0.01, 86400.0))
        ->capture_default_str();
    command.add_option("--clip", run.clip, "level at which the microphone clips; 0: not known")
        ->check(CLI::NonNegativeNumber);
    command.add_flag("--free-running",
                     run.isFreeRunning,
                     "the instrument writes by its own clock: lines from before are dropped");
    command.add_flag(
        "--all-places", run.goesToAllPlaces, "goes on to the next place without a stop");
    command.add_flag("--anew", run.begins, "reads the place that isn't complete from its start");
    command.add_flag("--quiet", run.isQuiet, "no progress");
}

void addFitting(CLI::App& command, TuneArguments& arguments)
{
    haptics::TuningFitOptions& fit = arguments.fit;
    addPlan(command, arguments);
    addArray(command, arguments, "as for the plan");
    command.add_option("--readings", arguments.readings, "the readings")->capture_default_str();
    command.add_option("--out", arguments.out, "array file (tuned.json)");
    command.add_option(
        "--picture", arguments.picture, "picture: .svg, .png or .pdf (beside it, .svg)");
    command
        .add_option("--search", fit.prior.search_m, "m that the microphone may be off its place")
        ->transform(in("m"))
        ->check(CLI::Range(0.0, 0.05))
        ->capture_default_str();
    command.add_option("--temperature", fit.prior.temperature_C, "C, of the air")
        ->check(CLI::Range(-40.0, 60.0))
        ->capture_default_str();
    command.add_option("--temperature-error", fit.prior.temperatureError_C, "K that it may be off")
        ->check(CLI::Range(0.0, 50.0))
        ->capture_default_str();
    command.add_option("--dead", fit.deadGain, "gain below which a transducer is dead")
        ->check(CLI::Range(0.01, 0.5))
        ->capture_default_str();
    command.add_option("--clip", fit.clip, "level at which the microphone clips; 0: not known")
        ->check(CLI::NonNegativeNumber);
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
    addArray(command, arguments, "as for the plan; of the method focus: the one before tuning");
    command.add_option("--tuned", arguments.tuned, "of the method focus: the tuned array");
    command.add_flag("--serve", arguments.serves, "answers rows on stdin, for exec:");
    command.add_option("--truth", arguments.truth, "writes the hidden array to this file");
    command.add_option("--seed", hidden.seed, "of chance")->capture_default_str();
    command.add_option("--detuning", hidden.detuning_Hz, "Hz, rms")->capture_default_str();
    command.add_option("--reversed", hidden.reversed, "share of reversed transducers")
        ->capture_default_str();
    command.add_option("--dead", hidden.dead, "share of dead ones")->capture_default_str();
    command.add_option("--gain-spread", hidden.gainSpread, "of gains, besides")
        ->capture_default_str();
    command.add_option("--place-error", hidden.placeError_m, "m, rms")
        ->transform(in("m"))
        ->capture_default_str();
    command.add_option("--temperature", hidden.temperature_C, "C, of the air")
        ->capture_default_str();
    command.add_option("--noise", hidden.noise_dB, "dB beside one transducer")
        ->capture_default_str();
    command.add_option("--reflections", hidden.reflections_dB, "dB beside what comes straight")
        ->capture_default_str();
    command.add_option("--clip", hidden.clip, "Pa at which the microphone clips; 0: never")
        ->capture_default_str();
    command.add_option("--sensitivity", hidden.sensitivity, "of the microphone, units/Pa")
        ->capture_default_str();
}

} // namespace

int main(int argc, char** argv)
{
    device::registerRehearsedAutd3();
    TuneArguments arguments;
    CLI::App app(
        "Finds the phase and gain of each transducer of an array with one microphone: plan, "
        "run, fit; then plan --method focus, run, check. rehearse answers for a simulated "
        "instrument with hidden errors.\n"
        "Exit codes: 0 done, 1 more to do (the same command goes on), 2 wrong input, 3 the "
        "device failed, 4 refused, over 100 called wrongly.",
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
    command("plan", "writes what is to be played", addPlanning, planTuning);
    command("run", "plays it and takes the readings", addRunning, runTuning);
    command("fit", "makes an array file of the readings", addFitting, fitArray);
    command("check",
            "compares foci of the tuned array with what they should be",
            addChecking,
            checkArray);
    command("rehearse",
            "prints readings of a simulated array with hidden errors",
            addRehearsing,
            rehearse);
    CLI11_PARSE(app, argc, argv);
    catchStopSignals();
    std::signal(SIGPIPE, SIG_IGN);
    try
    {
        return chosen(arguments);
    }
    catch (const device::DeviceError& error)
    {
        std::cerr << "midair-tune: " << error.what() << "\n";
        return DEVICE_FAILED;
    }
    catch (const std::exception& error)
    {
        std::cerr << "midair-tune: " << error.what() << "\n";
        return WRONG_INPUT;
    }
}
