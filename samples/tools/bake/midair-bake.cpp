// Solves an animation beforehand, as accurately as the kit can, on one core or on many machines,
// and writes a recording that any device plays.

#include "haptics/base/InputError.h"
#include "haptics/base/text/Quantity.h"
#include "samples/shared/SettingOptions.h"
#include "samples/tools/bake/Bake.h"

#include <cstdio>
#include <exception>

#include <CLI/CLI.hpp>

namespace
{

using namespace midair::samples;

/// What is to be done besides solving.
struct Mode
{
    std::string frames;
    std::vector<std::string> parts; ///< to merge
    bool estimate = false;
    int processes = 0; ///< over 0: measures scaling
    int repeats = 5;
};

void addOptions(CLI::App& app, BakeArguments& arguments, Mode& mode)
{
    app.add_option(
        "scene", arguments.scene, "Scene or model, as osgviewer reads it (MODEL.haptic too)");
    app.add_option("--frames", mode.frames, "A:B, frames A to B - 1; frame k is at k/FPS seconds");
    app.add_option("--fps", arguments.fps, "Frames per second")
        ->transform(inUnit("Hz", midair::base::parseQuantity))
        ->check(CLI::Range(0.01, 40000.0))
        ->capture_default_str();
    app.add_option("--out",
                   arguments.out,
                   "The recording; with --shard the part, to be merged with the others");
    app.add_option("--shard",
                   arguments.shard,
                   "i/K: solve every K-th chunk from the i-th on; the same bytes for any K")
        ->capture_default_str();
    auto* merge =
        app.add_option("--merge", mode.parts, "Parts of all shards, which become the recording");
    app.add_option("--chunk",
                   arguments.chunk,
                   "Frames between two starts from nothing; part of what the bytes depend on")
        ->check(CLI::Range(1, 1000000))
        ->capture_default_str();
    app.add_option("--threads", arguments.threads, "Threads of a solve; the same bytes for any")
        ->check(CLI::Range(1, 256))
        ->capture_default_str();
    app.add_option("--device",
                   arguments.settings,
                   "File of settings, as for osgviewer's --device FILE.haptic");
    app.add_option("-O,--options", arguments.options, "Options, as for osgviewer's -O");
    app.add_flag("--without-live",
                 arguments.withoutLive,
                 "Leave out what can't be known beforehand (hands, rigid bodies, particles, "
                 "films), which is refused else");
    app.add_flag("--overwrite", arguments.overwrite, "Replace --out even if it is something else");
    app.add_flag("--quiet", arguments.quiet, "No progress");
    app.add_flag("--estimate",
                 mode.estimate,
                 "Solve one chunk and print what 10^6 fields of this scene cost; writes nothing")
        ->excludes(merge);
    app.add_option("--scaling",
                   mode.processes,
                   "Bake the frames with one process and with this many, and print how that "
                   "scales; writes nothing")
        ->check(CLI::Range(2, 1024))
        ->excludes(merge);
    app.add_option("--repeats", mode.repeats, "Repeats of --scaling")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
}

int run(BakeArguments& arguments, const Mode& mode)
{
    using midair::base::InputError;
    const bool writes = !mode.estimate && mode.processes == 0;
    if (writes && arguments.out.empty()) throw InputError("say --out FILE");
    if (!mode.parts.empty())
    {
        if (!arguments.scene.empty() || !mode.frames.empty())
            throw InputError("--merge takes parts, and no scene and no --frames");
        mergeBaked(mode.parts, arguments.out, arguments.overwrite);
        return 0;
    }
    if (arguments.scene.empty()) throw InputError("name a scene, or --merge PARTS");
    parseFrames(mode.frames, arguments);
    if (mode.estimate)
        estimate(arguments);
    else if (mode.processes > 0)
        measureScaling(arguments, mode.processes, mode.repeats);
    else
        return bake(arguments);
    return 0;
}

} // namespace

int main(int argc, char** argv)
{
    constexpr int kWrong = 2;
    BakeArguments arguments;
    Mode mode;
    CLI::App app("midair-bake: solves an animation beforehand, as accurately as the kit can, and "
                 "writes a recording that any device plays (play:FILE?to=DEVICE). What is "
                 "finished is kept when it is ended: the same command goes on.\n"
                 "Exit code: 0 done, 1 done and all frames are silent, 2 something is wrong.",
                 "midair-bake");
    addOptions(app, arguments, mode);
    try
    {
        app.parse(argc, argv);
        return run(arguments, mode);
    }
    catch (const CLI::ParseError& error)
    {
        return app.exit(error) == 0 ? 0 : kWrong;
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "midair-bake: %s\n", error.what());
        return kWrong;
    }
}
