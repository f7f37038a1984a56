// midair-sense: shows what a sensation does, without an array: figures, samples and a picture.
// Plays one on an array, or those of an AdapTics Designer.

#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Words.h"
#include "haptics/sensation/SensationClassics.h"
#include "haptics/sensation/SensationEvaluator.h"
#include "haptics/sensation/SensationFigures.h"
#include "haptics/sensation/SensationPlayer.h"
#include "haptics/sensation/SensationReader.h"
#include "samples/shared/SensationOnDevice.h"
#include "samples/shared/ToolOptions.h"
#include "samples/tools/sense/SenseFiles.h"
#include "samples/tools/sense/SenseLive.h"
#include "samples/tools/sense/SensePicture.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace
{

using namespace midair;
using namespace midair::samples;
using base::InputError;

constexpr double kMeasured_ms = 10000.0; ///< of a pattern that doesn't stop, unless it is given
constexpr double kMostSamples = 1e7;

/// Options of midair-sense.
struct SenseArguments
{
    std::string name;
    std::string csv;
    std::string parametersFile;
    std::vector<std::string> set; ///< NAME=VALUE
    std::string picture;
    double rate_Hz = 1000.0;
    double duration_s = 0.0; ///< 0: until the pattern stops
    std::uint64_t seed = 1;
    bool conformance = false;
    bool list = false;
    bool play = false;
    bool serve = false;
};

/// Options of what is played on an array.
struct LiveArguments
{
    SensePlaybackOptions on;
    std::vector<double> place_m;
    double seconds = 0.0; ///< 0: until the pattern stops
    int port = 8037;
    std::vector<std::string> origins;
};

void addOptions(CLI::App& app, SenseArguments& arguments)
{
    app.add_option("sensation",
                   arguments.name,
                   "an .adaptics file, or a classic with parameters: circle?radius=20mm");
    app.add_flag("--list", arguments.list, "list the classics and their parameters");
    app.add_option("--csv", arguments.csv, "write samples as CSV to this file; -: to stdout");
    app.add_option("--rate", arguments.rate_Hz, "fields a second, Hz")
        ->check(CLI::Range(1.0, 40000.0))
        ->capture_default_str();
    app.add_option(
           "--duration", arguments.duration_s, "s; default: until the pattern stops, at most 10 s")
        ->check(CLI::Range(1e-3, 3600.0));
    app.add_option("--set", arguments.set, "set a parameter: NAME=VALUE; may be repeated");
    app.add_option("--params",
                   arguments.parametersFile,
                   "CSV file t_ms,name,value: parameters and from when on they are set");
    app.add_option("--seed", arguments.seed, "of random intensities")->capture_default_str();
    app.add_flag("--conformance",
                 arguments.conformance,
                 "evaluate as AdapTics' evaluator does, to compare with it");
    app.add_option("--picture",
                   arguments.picture,
                   "draw path, intensity and spectrum into this .png, .svg or .pdf file");
}

void addLiveOptions(CLI::App& app, SenseArguments& arguments, LiveArguments& live)
{
    CLI::Option* const play = app.add_flag("--play", arguments.play, "play it on an array");
    app.add_flag("--serve",
                 arguments.serve,
                 "play what an AdapTics Designer on this machine sends (ws://127.0.0.1:PORT/)")
        ->excludes(play);
    app.add_option("--device", live.on.device, "URI of the device, as for scenes")
        ->capture_default_str();
    app.add_option("--array", live.on.array, "octagon, board, a shipped array, or a JSON file")
        ->capture_default_str();
    app.add_option("--pressure", live.on.pressure_Pa, "peak pressure at intensity 1, Pa")
        ->check(CLI::Range(1.0, 1e5))
        ->capture_default_str();
    app.add_option("--place",
                   live.place_m,
                   "X Y Z, m, in the array's frame: the middle of a classic, or (0, 0, 200) mm of "
                   "a file; default: 0.2 m in front of the array, or the origin within it")
        ->expected(3);
    app.add_option("--hands", live.on.hands, "source of hands, for the Designer's tracking");
    app.add_option("--seconds", live.seconds, "--play: s; default: until the pattern stops")
        ->check(CLI::Range(1e-3, 86400.0));
    app.add_option("--port", live.port, "--serve: port; 0: any free one")
        ->check(CLI::Range(0, 65535))
        ->capture_default_str();
    app.add_option("--origin",
                   live.origins,
                   "--serve: a page that may connect, such as https://example.org; may be "
                   "repeated; pages of this machine always may")
        ->allow_extra_args(false);
}

/// Returns the parameters of --set, at the start, and then those of --params.
std::vector<SetParameter> parametersOf(const SenseArguments& arguments)
{
    std::vector<SetParameter> all;
    for (const std::string& text : arguments.set)
    {
        const std::size_t equal = text.rfind('=');
        SetParameter one;
        if (equal == std::string::npos || equal == 0 ||
            !base::parseNumber(text.substr(equal + 1), one.value))
            throw InputError("--set \"" + base::printable(text, 60) +
                             "\" should be NAME=VALUE with a number");
        one.name = text.substr(0, equal);
        all.push_back(one);
    }
    if (arguments.parametersFile.empty()) return all;
    for (SetParameter& one : readSetParameters(arguments.parametersFile))
        all.push_back(std::move(one));
    return all;
}

using SharedSensation = std::shared_ptr<const haptics::Sensation>;

/// Returns the samples at \a rate_Hz of \a end_ms.
std::vector<TimedSample> sampled(const SharedSensation& sensation,
                                 const SenseArguments& arguments,
                                 const std::vector<SetParameter>& set,
                                 double end_ms)
{
    const double count = std::floor(end_ms * 1e-3 * arguments.rate_Hz + 1e-9) + 1.0;
    if (count > kMostSamples)
        throw InputError(
            fmt::format("{} s at {} Hz are too many samples", 1e-3 * end_ms, arguments.rate_Hz));
    const haptics::SensationEvaluator evaluator(sensation, arguments.seed);
    haptics::SensationState state;
    haptics::SensationPlayerOptions options;
    options.seed = arguments.seed;
    haptics::SensationPlayer player(sensation, options);
    std::size_t next = 0;
    std::vector<TimedSample> samples;
    for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k)
    {
        TimedSample one;
        one.time_ms = 1e3 * static_cast<double>(k) / arguments.rate_Hz;
        setDue(set, one.time_ms, next, player.values());
        one.sample = arguments.conformance ? evaluator.evaluate(one.time_ms, player.values(), state)
                                           : player.sampleAt(one.time_ms);
        samples.push_back(one);
    }
    return samples;
}

/// \a isLive: the device plays each field as it comes.
void printFigures(const haptics::SensationFigures& figures, double rate_Hz, bool isLive)
{
    if (std::isnan(figures.low_mm.x()))
        std::printf("extent      none: it is silent\n");
    else
        std::printf("extent      x %.1f .. %.1f, y %.1f .. %.1f, z %.1f .. %.1f mm\n",
                    figures.low_mm.x(),
                    figures.high_mm.x(),
                    figures.low_mm.y(),
                    figures.high_mm.y(),
                    figures.low_mm.z(),
                    figures.high_mm.z());
    if (figures.duration_ms)
        std::printf("duration    %.1f ms\n", *figures.duration_ms);
    else
        std::printf("duration    never stops\n");
    std::printf("draw speed  %.2f m/s (median)\n", figures.speed_m_s);
    const double points = figures.pointsPerTurn(rate_Hz);
    if (std::isfinite(points))
        std::printf("turns       %.4g Hz: %.1f points a turn at %.4g fields/s%s\n",
                    figures.draw_Hz,
                    points,
                    rate_Hz,
                    isLive && points < haptics::SensationFigures::kLeastPoints ? ", too few" : "");
    if (figures.modulation_Hz > 0.0) std::printf("modulation  %.4g Hz\n", figures.modulation_Hz);
    std::printf("intensity   up to %.3g\n", figures.mostIntensity);
}

/// Says once what of a pattern isn't played as it asks.
void printProblems(bool isBroken, bool isLimited)
{
    if (isBroken)
        std::fprintf(stderr,
                     "midair-sense: a formula gives NaN or infinity; these samples are silent\n");
    if (isLimited)
        std::fprintf(stderr,
                     "midair-sense: the pattern asks for intensities outside 0 .. 1; they are "
                     "limited\n");
}

void writeCsv(const std::string& path, const std::vector<TimedSample>& samples)
{
    if (path == "-") return writeSamples(std::cout, samples);
    std::ofstream out(path, std::ios::binary);
    writeSamples(out, samples);
    out.flush();
    if (!out) throw InputError("\"" + path + "\" can't be written");
}

int listClassics()
{
    for (const std::string& name : haptics::sensationClassics())
        std::fputs(haptics::describeClassic(name).c_str(), stdout);
    return EXIT_DONE;
}

int show(const SenseArguments& arguments, const SensePlaybackOptions& on)
{
    const auto sensation =
        std::make_shared<const haptics::Sensation>(haptics::loadSensation(arguments.name));
    const std::vector<SetParameter> set = parametersOf(arguments);
    haptics::SensationPlayer player(sensation);
    std::size_t next = 0;
    setDue(set, 0.0, next, player.values());
    const double most_ms = arguments.duration_s > 0.0 ? 1e3 * arguments.duration_s : kMeasured_ms;
    const haptics::SensationFigures figures = haptics::measureSensation(player, most_ms);

    if (arguments.csv != "-")
    {
        const int transducers = haptics::TransducerArray::load(on.array).size();
        const auto store = storeOf(on.device, transducers, arguments.rate_Hz);
        const std::string made = store ? onDevice(player, figures, *store) : std::string();
        printFigures(figures, arguments.rate_Hz, made.empty());
        std::printf("device      %s %s\n",
                    on.device.c_str(),
                    !store         ? "says what it takes when it is open"
                    : made.empty() ? "plays every field"
                                   : made.c_str());
    }
    if (!arguments.conformance) printProblems(figures.isBroken, figures.isLimited);
    if (arguments.csv.empty() && arguments.picture.empty()) return EXIT_DONE;
    const double end_ms =
        arguments.duration_s > 0.0 ? most_ms : figures.duration_ms.value_or(most_ms);
    const std::vector<TimedSample> samples = sampled(sensation, arguments, set, end_ms);
    if (!arguments.csv.empty()) writeCsv(arguments.csv, samples);
    if (arguments.picture.empty()) return EXIT_DONE;
    const std::string problem = drawSensation(arguments.picture, sensation->name, samples);
    if (!problem.empty()) throw InputError(problem);
    return EXIT_DONE;
}

int run(int argc, char** argv)
{
    SenseArguments arguments;
    LiveArguments live;
    CLI::App app("Shows what a sensation does, without an array: extent, duration, draw speed and "
                 "points a turn; samples as CSV; a picture. Or plays it.\n"
                 "Examples: midair-sense 'circle?radius=30mm' --rate 1000 --csv circle.csv\n"
                 "          midair-sense heartbeat --play --device usb: --array board\n"
                 "          midair-sense --serve --device usb: --array board",
                 "midair-sense");
    addOptions(app, arguments);
    addLiveOptions(app, arguments, live);
    int status = EXIT_DONE;
    if (!parseTool(app, argc, argv, status)) return status;
    if (arguments.list) return listClassics();
    live.on.seed = arguments.seed;
    if (!live.place_m.empty())
        live.on.place_m = Eigen::Vector3d(live.place_m[0], live.place_m[1], live.place_m[2]);
    if (arguments.serve && !arguments.name.empty())
        throw InputError("--serve takes no sensation: the Designer sends it");
    if (arguments.serve) return serveDesigner(live.port, live.origins, live.on);
    if (arguments.name.empty())
        throw InputError("name an .adaptics file or a classic; --list lists the classics");
    if (!arguments.play) return show(arguments, live.on);
    return playSensation({arguments.name, parametersOf(arguments), live.seconds}, live.on);
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
        std::fprintf(stderr, "midair-sense: %s\n", error.what());
        return EXIT_WRONG;
    }
}
