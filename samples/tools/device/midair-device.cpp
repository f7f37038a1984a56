// Tool for an array without a scene: lists devices, shows their status, plays test patterns and
// recordings, measures rates.

#include "device/autd3/emulator/RehearsedAutd3.h"
#include "samples/tools/device/DeviceTool.h"

#include <cmath>
#include <csignal>
#include <exception>
#include <iostream>

#include <CLI/CLI.hpp>

using namespace midair;
using namespace midair::samples;

int main(int argc, char** argv)
{
    device::registerRehearsedAutd3();
    DeviceOptions options;
    CLI::App app(
        "Looks after an ultrasound array. Devices:\n" + device::deviceKinds() +
        "A list with commas opens several as one; "
        "?max-amplitude=0.2&max-pressure=800&ramp=50ms&mean-drive=0.3 limit any of them.\n"
        "Exit codes: 0 fine, 2 nothing found, 3 can't be opened, 4 the device failed or played "
        "less than half, over 100 "
        "called wrongly.");
    app.require_subcommand(1);
    app.add_option(
           "--array", options.array, "octagon, board, a shipped array's name or a JSON file")
        ->capture_default_str();
    app.add_option("--device", options.device, "which device")->capture_default_str();
    CLI::Option* seconds = app.add_option("--seconds", options.seconds, "how long");
    seconds->capture_default_str()->check(CLI::Range(0.0, 1e6));
    app.add_option("--rate", options.rate_Hz, "fields a second")
        ->capture_default_str()
        ->check(CLI::Range(0.1, 1e5));
    app.add_option("--amplitude", options.amplitude, "of full drive")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 1.0));
    app.fallthrough();
    int (*chosen)(const DeviceOptions&) = nullptr;
    const auto command = [&](const char* name, const char* text, int (*run)(const DeviceOptions&))
    {
        CLI::App* sub = app.add_subcommand(name, text);
        sub->callback([&chosen, run] { chosen = run; });
        return sub;
    };
    command("list", "what is plugged in", listDevices);
    command("status", "how the device fares, and its firmware's version", showStatus);
    command("identify", "blinks the lamp of a board, or of all", identifyBoards)
        ->add_option("--board", options.board, "which board")
        ->check(CLI::Range(0, 65534));
    command("mute", "takes all transducers off", muteArray);
    command("boards", "one board after the other sounds", playBoards);
    command("transducers", "one transducer after the other sounds", playTransducers);
    CLI::App* circling = command("circle", "a focus walks on a circle", playCircle);
    circling->add_option("--radius", options.radius_m, "m")->capture_default_str();
    circling->add_option("--turns", options.turnsPerSecond, "a second")->capture_default_str();
    command("measure", "fields a second and latency", measureRates);
    command("play", "plays a recording (made with record:FILE) on the device", playRecording)
        ->add_option("FILE", options.file, "the recording")
        ->required();
    CLI::App* importing =
        command("import-pat", "makes an array file of an OpenMPD board's .pat file", importPat);
    importing->add_option("FILE", options.file, "the .pat file")->required();
    importing->add_option("--out", options.out, "the array file")->required();
    CLI::App* simulated = command("import-ultraino",
                                  "makes an array file of a simulation that Ultraino has saved",
                                  importUltraino);
    simulated->add_option("FILE", options.file, "the .xml.gz file")->required();
    simulated->add_option("--out", options.out, "the array file")->required();
    CLI::App* emulating =
        command("emulate", "answers as AUTD3 units would, until --seconds or Ctrl-C", emulateUnits);
    std::string kind;
    emulating->add_option("KIND", kind, "autd3")->required()->check(CLI::IsMember({"autd3"}));
    emulating->add_option("--units", options.units, "how many")
        ->capture_default_str()
        ->check(CLI::Range(1, 64));
    emulating
        ->add_option("--port", options.port, "of ::1, for the group; 0: any; ids get their own")
        ->capture_default_str()
        ->check(CLI::Range(0, 65535));
    emulating->add_option("--faults", options.faults, "such as \"drop=0.01&reboot_at=5s\"");
    CLI11_PARSE(app, argc, argv);
    options.hasSeconds = seconds->count() > 0;
    for (const double number : {options.seconds,
                                options.rate_Hz,
                                options.amplitude,
                                options.radius_m,
                                options.turnsPerSecond})
        if (!std::isfinite(number)) // ranges don't refuse nan
            return app.exit(CLI::ValidationError("options", "nan and inf are no numbers here"));
    std::signal(SIGINT, [](int) { interrupted = true; });
    std::signal(SIGTERM, [](int) { interrupted = true; });
    try
    {
        return chosen(options);
    }
    catch (const std::exception& error)
    {
        std::cerr << error.what() << "\n";
        return CANNOT_OPEN;
    }
}
