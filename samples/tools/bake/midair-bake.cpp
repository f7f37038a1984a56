// Solves an animation in advance, as accurately as the kit can, on one core or many machines, and
// writes a recording for any device.
#include "haptics/base/InputError.h"
#include "haptics/base/Percentile.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Quantity.h"
#include "haptics/base/threads/SteadyClock.h"
#include "samples/shared/SettingOptions.h"
#include "samples/shared/ToolOptions.h"
#include "samples/shared/shards/Shards.h"
#include "samples/tools/bake/BakeScene.h"

#include <osgMidair/Recording>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <filesystem>

#include <CLI/CLI.hpp>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace
{

using namespace midair;
using namespace midair::samples;
using osgMidair::BakedField;
using osgMidair::RecordingReader;
using osgMidair::RecordingWriter;

/// Totals of a shard, for the summary.
struct Baked
{
    std::uint64_t frames = 0;
    std::uint64_t fields = 0;
    std::uint64_t silent = 0; ///< frames
    std::uint64_t silenced = 0;
    std::uint64_t evened = 0; ///< frames
    double worstRms = 0.0;    ///< of the others
    std::uint64_t points = 0; ///< largest number in a frame
};

/// Throws base::InputError if the field can't be recorded.
void addTo(RecordingWriter& writer, const BakedField& field)
{
    if (!writer.record(field)) throw base::InputError("a field can't be stored in the recording");
}

/// Solves a chunk without a previous field. Returns a complete recording.
std::string
bakeChunk(BakeScene& scene, const BakeArguments& arguments, std::uint64_t chunk, Baked& baked)
{
    scene.restart();
    const osg::ref_ptr<RecordingWriter> writer = new RecordingWriter(scene.transducers());
    const auto size = static_cast<std::uint64_t>(arguments.chunk);
    const std::uint64_t end = std::min((chunk + 1) * size, arguments.frames());
    for (std::uint64_t number = chunk * size; number < end; ++number)
    {
        const osgMidair::BakedFrame frame = scene.bake(number);
        for (const BakedField& field : frame.fields)
            addTo(*writer, field);
        ++baked.frames;
        baked.fields += frame.fields.size();
        if (frame.fields.front().phase.empty()) ++baked.silent;
        if (frame.isSilenced) ++baked.silenced;
        if (frame.isEvened)
            ++baked.evened;
        else
            baked.worstRms = std::max(baked.worstRms, frame.rms);
        baked.points = std::max<std::uint64_t>(baked.points, frame.points);
    }
    writer->end(arguments.time_ns(end));
    return writer->take();
}

void tell(const std::string& line)
{
    std::fprintf(stderr, "midair-bake: %s\n", line.c_str());
}

void tellResult(const Baked& baked, const BakeScene& scene)
{
    for (const std::string& message : scene.messages())
        tell(message);
    if (baked.frames == 0) return;
    std::printf("%llu frames, %llu fields; at most %llu points",
                static_cast<unsigned long long>(baked.frames),
                static_cast<unsigned long long>(baked.fields),
                static_cast<unsigned long long>(baked.points));
    if (baked.evened > 0)
        std::printf("; %llu frames are even over their surfaces",
                    static_cast<unsigned long long>(baked.evened));
    if (baked.evened < baked.frames)
        std::printf("; rms error %sat most %.3f %%",
                    baked.evened > 0 ? "of the others " : "",
                    100.0 * baked.worstRms);
    std::printf("\n");
    if (baked.silent > 0)
        std::printf("%llu of these frames are silent, %llu of them because of caps\n",
                    static_cast<unsigned long long>(baked.silent),
                    static_cast<unsigned long long>(baked.silenced));
}

constexpr int kLevels = 256;
constexpr int kMostTransducers = 1 << 20;                     // in a recording
constexpr std::uint64_t kMostPlayed = std::uint64_t(2) << 30; // largest recording that play:
                                                              // accepts

std::string framesOf(const nlohmann::json& work, std::uint64_t piece)
{
    const auto first = work.value("firstFrame", std::int64_t(0));
    const auto end = work.value("endFrame", std::int64_t(0));
    const auto chunk = work.value("chunk", std::int64_t(1));
    const std::int64_t begin = first + static_cast<std::int64_t>(piece) * chunk;
    return fmt::format("frames {} to {}", begin, std::min(begin + chunk, end) - 1);
}

/// Returns the common phase shift, in levels, that makes \a next differ least from \a last. A
/// common shift can't be felt. It is the argmax over r of Re sum a a' e^{j 2 pi (next + r -
/// last)/256}, with amplitudes from the duty levels.
int turnBetween(const BakedField& last, const BakedField& next)
{
    // Exact integers so far, so the order of summation doesn't matter.
    std::array<double, kLevels> weights{};
    for (std::size_t i = 0; i < next.phase.size() && i < last.phase.size(); ++i)
    {
        const auto step = static_cast<std::uint8_t>(next.phase[i] - last.phase[i]);
        weights[step] += static_cast<double>(last.duty[i]) * next.duty[i];
    }
    std::complex<double> sum = 0.0;
    for (int step = 0; step < kLevels; ++step)
        sum += weights[static_cast<std::size_t>(step)] *
               std::polar(1.0, base::kTwoPi * step / kLevels);
    if (std::abs(sum) == 0.0) return 0;
    const long turn = std::lround(-std::arg(sum) * kLevels / base::kTwoPi);
    return static_cast<int>((turn + kLevels) % kLevels);
}

/// Concatenates chunks.
class Joiner
{
public:
    Joiner(unsigned int transducers, WholeFile& file) :
        _transducers(transducers),
        _writer(new RecordingWriter(transducers)),
        _file(file)
    {
    }

    void add(const std::string& payload, const std::string& name)
    {
        std::string error;
        const osg::ref_ptr<RecordingReader> reader = RecordingReader::read(payload, name, error);
        if (!reader) throw base::InputError(error);
        if (reader->getNumTransducers() != _transducers)
            throw base::InputError(name + " has a different number of transducers");
        bool isFirst = true;
        BakedField field;
        while (reader->next(field))
        {
            if (!field.phase.empty())
            {
                // The phases of a chunk's first field are arbitrary, so align them with the
                // previous field.
                if (isFirst) _turn = _last.phase.empty() ? 0 : turnBetween(_last, field);
                isFirst = false;
                for (std::uint8_t& phase : field.phase)
                    phase = static_cast<std::uint8_t>(phase + _turn);
                ++_fields;
            }
            addTo(*_writer, field);
            _last = field;
        }
        if (!reader->getError().empty()) throw base::InputError(name + " is incomplete");
        put();
    }

    void end(std::uint64_t time_ns)
    {
        _writer->end(time_ns);
        put();
    }
    std::uint64_t fields() const { return _fields; }

private:
    void put()
    {
        const std::string bytes = _writer->take();
        _file.write(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    }

    const unsigned int _transducers;
    const osg::ref_ptr<RecordingWriter> _writer;
    WholeFile& _file;
    BakedField _last; ///< no phases: silence
    int _turn = 0;
    std::uint64_t _fields = 0;
};

/// Merges \a parts into a recording. Throws base::InputError.
void mergeBaked(const std::vector<std::string>& parts, const std::string& out, bool overwrite)
{
    const JoinedParts joined(parts, framesOf);
    const nlohmann::json& work = joined.work();
    if (work.value("what", "") != "midair-bake 1")
        throw base::InputError(fmt::format("\"{}\" is not a part of midair-bake, but of {}",
                                           parts.front(),
                                           work.value("what", "something else")));
    BakeArguments arguments;
    arguments.first = work.value("firstFrame", std::int64_t(0));
    arguments.end = work.value("endFrame", std::int64_t(0));
    arguments.fps = work.value("fps", 60.0);
    const std::string transducers =
        work.contains("settings") ? work["settings"].value("transducers", "0") : "0";
    int count = 0;
    if (!base::parseWhole(transducers, count) || count < 1 || count > kMostTransducers)
        throw base::InputError(fmt::format("\"{}\" is for \"{}\" transducers, should be 1 .. {}",
                                           parts.front(),
                                           transducers,
                                           kMostTransducers));
    WholeFile file(out, RecordingWriter::kBeginning, overwrite);
    Joiner joiner(static_cast<unsigned int>(count), file);
    for (std::uint64_t piece = 0; piece < joined.pieces(); ++piece)
        joiner.add(joined.read(piece), framesOf(work, piece));
    joiner.end(arguments.time_ns(arguments.frames()));
    file.commit();
    std::printf("%s: %llu fields, %.3f s, %llu bytes\n",
                out.c_str(),
                static_cast<unsigned long long>(joiner.fields()),
                1e-9 * static_cast<double>(arguments.time_ns(arguments.frames())),
                static_cast<unsigned long long>(file.size()));
    if (file.size() > kMostPlayed)
        std::fprintf(stderr,
                     "midair-bake: play: accepts recordings of at most 2 GiB; bake shorter ranges "
                     "of frames\n");
}

/// Solves a shard. A single shard (1/1) writes the recording to \a arguments.out and keeps its
/// progress in a part file beside it; other shards write a part. Continues an existing part.
/// Returns the exit code: 0, or 1 if all its frames are silent. Throws base::InputError.
int bake(const BakeArguments& arguments)
{
    const Shard shard = parseShard(arguments.shard);
    const bool isWhole = shard.count == 1;
    BakeScene scene(arguments);
    for (const std::string& note : scene.notes())
        tell(note);
    PartHeader header{scene.work(), shard.number, shard.count, arguments.chunks()};
    if (isWhole)
        WholeFile(arguments.out, RecordingWriter::kBeginning, arguments.overwrite); // told now
    const std::string file = isWhole ? arguments.out + ".part" : arguments.out;
    Baked baked;
    {
        PartFile part = PartFile::openToGoOn(file, header);
        if (!part.damage().empty())
            tell(fmt::format("\"{}\": {}; solving it again", file, part.damage()));
        if (part.pieces() > 0)
            tell(fmt::format("\"{}\" already has {} of {} chunks; continuing",
                             file,
                             part.pieces(),
                             header.share()));
        const auto size = static_cast<std::uint64_t>(arguments.chunk);
        Progress progress("frames",
                          std::min(part.pieces() * size, arguments.frames()),
                          isWhole ? arguments.frames()
                                  : std::min(header.share() * size, arguments.frames()),
                          arguments.quiet);
        for (std::uint64_t chunk = 0; chunk < header.pieces; ++chunk)
        {
            if (!header.has(chunk) || part.has(chunk)) continue;
            const std::uint64_t before = baked.frames;
            part.add(chunk, bakeChunk(scene, arguments, chunk, baked));
            progress.add(baked.frames - before);
        }
        part.sync();
    }
    tellResult(baked, scene);
    if (isWhole)
    {
        mergeBaked({file}, arguments.out, arguments.overwrite);
        ::unlink(file.c_str());
    }
    return baked.frames > 0 && baked.silent == baked.frames ? 1 : 0;
}

// The cost of baking: a model for many fields, and scaling with processes.

constexpr double kMany = 1e6;              // fields
constexpr double kPlayable = 2147483648.0; // largest recording that play: accepts

/// Processor time of this process, s.
double cpu_s()
{
    timespec now = {};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Time that one process took.
struct Run
{
    double wall_s = 0.0;
    double cpu_s = 0.0;
};

/// Starts a process that bakes one shard without output. It forks this program, which has no
/// threads yet.
pid_t start(BakeArguments arguments)
{
    arguments.quiet = true;
    const pid_t child = ::fork();
    if (child < 0) throw base::InputError("can't start a process");
    if (child > 0) return child;
    const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    ::dup2(nowhere, STDOUT_FILENO);
    ::dup2(nowhere, STDERR_FILENO);
    try
    {
        ::_exit(bake(arguments));
    }
    catch (...)
    {
        ::_exit(2);
    }
}

/// Bakes shards 1 to \a running of \a shards in parallel.
std::vector<Run> runAll(BakeArguments arguments, int running, int shards, const std::string& folder)
{
    const double begin_s = base::steadySeconds();
    std::vector<pid_t> children;
    for (int shard = 1; shard <= running; ++shard)
    {
        arguments.shard = fmt::format("{}/{}", shard, shards);
        arguments.out = fmt::format("{}/{}.part", folder, shard);
        std::filesystem::remove(arguments.out);
        children.push_back(start(arguments));
    }
    std::vector<Run> runs;
    bool failed = false;
    for (const pid_t child : children)
    {
        rusage usage = {};
        int status = 0;
        if (::wait4(child, &status, 0, &usage) != child) failed = true;
        failed = failed || !WIFEXITED(status) || WEXITSTATUS(status) > 1;
        const auto seconds = [](const timeval& time)
        { return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec); };
        runs.push_back(
            {base::steadySeconds() - begin_s, seconds(usage.ru_utime) + seconds(usage.ru_stime)});
    }
    if (failed) throw base::InputError("a baking process has failed");
    return runs;
}

/// Median times and mean sizes per frame.
struct FrameCost
{
    std::uint64_t frames = 0; ///< measured
    double start_s = 0.0;     ///< core time without a previous field
    double update_s = 0.0;    ///< core time with a previous field
    double fields = 0.0;      ///< per frame
    double fieldBytes = 0.0;
};

FrameCost costOfFrames(BakeScene& scene, const BakeArguments& arguments)
{
    FrameCost cost;
    cost.frames = std::min(arguments.frames(), static_cast<std::uint64_t>(arguments.chunk));
    // Restarts more often than a chunk does, to get enough samples of starts.
    const std::uint64_t between = std::max<std::uint64_t>(1, cost.frames / 4);
    std::vector<double> starts_s;
    std::vector<double> updates_s;
    const osg::ref_ptr<RecordingWriter> writer = new RecordingWriter(scene.transducers());
    writer->take(); // drop the header
    double bytes = 0.0;
    double fields = 0.0;
    for (std::uint64_t number = 0; number < cost.frames; ++number)
    {
        const bool isStart = number % between == 0;
        if (isStart) scene.restart();
        const double before_s = cpu_s();
        const osgMidair::BakedFrame frame = scene.bake(number);
        (isStart ? starts_s : updates_s).push_back(cpu_s() - before_s);
        for (const BakedField& field : frame.fields)
            addTo(*writer, field);
        bytes += static_cast<double>(writer->take().size());
        fields += static_cast<double>(frame.fields.size());
    }
    cost.start_s = base::percentile(starts_s, 0.5);
    cost.update_s = updates_s.empty() ? cost.start_s : base::percentile(updates_s, 0.5);
    cost.fields = fields / static_cast<double>(cost.frames);
    cost.fieldBytes = bytes / fields;
    return cost;
}

/// Solves some frames and prints a cost estimate for many: core time, bytes, and time on several
/// cores. Writes nothing.
void estimate(const BakeArguments& arguments)
{
    const double begin_s = cpu_s();
    BakeScene scene(arguments);
    const double load_s = cpu_s() - begin_s;
    const FrameCost cost = costOfFrames(scene, arguments);
    std::printf("medians of %llu frames, one process with %d %s\n"
                "  load the scene                  %8.0f ms of core time per process\n"
                "  first frame of a chunk          %8.2f ms of core time\n"
                "  each other frame                %8.2f ms of core time\n"
                "  fields per frame                %8.2f\n"
                "  bytes per field                 %8.0f\n",
                static_cast<unsigned long long>(cost.frames),
                arguments.threads,
                arguments.threads == 1 ? "thread" : "threads",
                1e3 * load_s,
                1e3 * cost.start_s,
                1e3 * cost.update_s,
                cost.fields,
                cost.fieldBytes);
    const double frame_s = cost.update_s + (cost.start_s - cost.update_s) / arguments.chunk;
    const auto cost_h = [&](double cores)
    { return (load_s + kMany / cost.fields * frame_s / cores) / 3600.0; };
    const bool isTooLong = kMany * cost.fieldBytes > kPlayable;
    std::printf("model: core time for N frames = N (%.2f ms + %.2f ms / %d) + %.0f ms per process\n"
                "10^6 fields\n"
                "  on one core                     %8.2f h\n"
                "  on 64 cores                     %8.2f h\n"
                "  file size                       %8.2f GB%s\n",
                1e3 * cost.update_s,
                1e3 * (cost.start_s - cost.update_s),
                arguments.chunk,
                1e3 * load_s,
                cost_h(1.0),
                cost_h(64.0),
                1e-9 * kMany * cost.fieldBytes,
                isTooLong ? "; play: accepts 2 GiB, so bake ranges of frames" : "");
}

/// Bakes with one process and with \a processes in parallel, \a repeats times each in turn, and
/// prints throughput and core time per frame.
void measureScaling(const BakeArguments& arguments, int processes, int repeats)
{
    std::string folder = (std::filesystem::temp_directory_path() / "midair-bake-XXXXXX").string();
    if (!::mkdtemp(folder.data())) throw base::InputError("can't create a folder " + folder);
    // Shard 1 alone, then all shards in parallel; each shard has the same number of chunks.
    const auto shardFrames = static_cast<double>(arguments.frames()) / processes;
    std::vector<double> single_ms;
    std::vector<double> together_ms;
    std::vector<double> ratios;
    std::vector<double> throughput;
    try
    {
        for (int repeat = 0; repeat < repeats; ++repeat)
        {
            const Run alone = runAll(arguments, 1, processes, folder).front();
            const std::vector<Run> all = runAll(arguments, processes, processes, folder);
            double total_s = 0.0;
            double wall_s = 0.0;
            for (const Run& run : all)
            {
                total_s += run.cpu_s;
                wall_s = std::max(wall_s, run.wall_s);
            }
            single_ms.push_back(1e3 * alone.cpu_s / shardFrames);
            together_ms.push_back(1e3 * total_s / (shardFrames * processes));
            ratios.push_back(single_ms.back() / together_ms.back());
            throughput.push_back(alone.wall_s / wall_s);
            std::printf("  %2d  1 process: %7.2f ms of core time per frame, %7.1f frames/s;  %d: "
                        "%7.2f ms, %7.1f frames/s\n",
                        repeat + 1,
                        single_ms.back(),
                        shardFrames / alone.wall_s,
                        processes,
                        together_ms.back(),
                        shardFrames * processes / wall_s);
            std::fflush(stdout);
        }
    }
    catch (...)
    {
        std::filesystem::remove_all(folder);
        throw;
    }
    std::filesystem::remove_all(folder);
    std::printf(
        "medians of %d: a frame takes %.2f ms of core time with 1 process, %.2f ms with %d\n"
        "  by core time           %.3f of linear\n"
        "  by wall clock          %.3f of linear (includes other load on this machine)\n",
        repeats,
        base::percentile(single_ms, 0.5),
        base::percentile(together_ms, 0.5),
        processes,
        base::percentile(ratios, 0.5),
        base::percentile(throughput, 0.5));
}

/// Options other than those of solving.
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
    app.add_option("scene",
                   arguments.scene,
                   "Scene or model, any file that osgviewer reads (MODEL.haptic too)");
    app.add_option(
        "--frames", mode.frames, "A:B for frames A to B - 1; frame k is at k/FPS seconds");
    app.add_option("--fps", arguments.fps, "Frames per second")
        ->transform(inUnit("Hz", midair::base::parseQuantity))
        ->check(CLI::Range(0.01, 40000.0))
        ->capture_default_str();
    app.add_option("--out",
                   arguments.out,
                   "Recording to write; with --shard, the part to be merged with the others");
    app.add_option(
           "--shard",
           arguments.shard,
           "i/K: solve every K-th chunk, starting with the i-th; the result is the same for any K")
        ->capture_default_str();
    auto* merge =
        app.add_option("--merge", mode.parts, "Merge the parts of all shards into the recording");
    app.add_option("--chunk",
                   arguments.chunk,
                   "Frames per chunk; each chunk starts without a previous field, so the result "
                   "depends on it")
        ->check(CLI::Range(1, 1000000))
        ->capture_default_str();
    app.add_option("--threads",
                   arguments.threads,
                   "Threads of a solve; the result is the same for any number")
        ->check(CLI::Range(1, 256))
        ->capture_default_str();
    app.add_option("--device",
                   arguments.settings,
                   "File of settings, as for osgviewer's --device FILE.haptic");
    app.add_option("-O,--options", arguments.options, "Options, as for osgviewer's -O");
    app.add_flag("--without-live",
                 arguments.withoutLive,
                 "Leave out what can't be baked (live hands, rigid bodies, particles, films) "
                 "instead of refusing the scene");
    app.add_flag("--overwrite", arguments.overwrite, "Replace --out even if it isn't a recording");
    app.add_flag("--quiet", arguments.quiet, "Don't print progress");
    app.add_flag("--estimate",
                 mode.estimate,
                 "Solve one chunk and print the cost of 10^6 fields of this scene; writes nothing")
        ->excludes(merge);
    app.add_option("--scaling",
                   mode.processes,
                   "Bake the frames with one process and with this many, and print how the speed "
                   "scales; writes nothing")
        ->check(CLI::Range(2, 1024))
        ->excludes(merge);
    app.add_option("--repeats", mode.repeats, "Repeats of --scaling")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
}

int work(BakeArguments& arguments, const Mode& mode)
{
    using midair::base::InputError;
    const bool writes = !mode.estimate && mode.processes == 0;
    if (writes && arguments.out.empty()) throw InputError("--out FILE is missing");
    if (!mode.parts.empty())
    {
        if (!arguments.scene.empty() || !mode.frames.empty())
            throw InputError("--merge takes only parts, no scene and no --frames");
        mergeBaked(mode.parts, arguments.out, arguments.overwrite);
        return 0;
    }
    if (arguments.scene.empty()) throw InputError("a scene or --merge PARTS is missing");
    parseFrames(mode.frames, arguments);
    if (mode.estimate)
        estimate(arguments);
    else if (mode.processes > 0)
        measureScaling(arguments, mode.processes, mode.repeats);
    else
        return bake(arguments);
    return 0;
}

int run(int argc, char** argv)
{
    BakeArguments arguments;
    Mode mode;
    CLI::App app("Solves an animation in advance, as accurately as the kit can, and writes a "
                 "recording for any device.\n"
                 "Example: midair-bake scene.osgt --frames 0:600 --out show.midair\n"
                 "The device play:show.midair?to=DEVICE plays it. If interrupted, the same command "
                 "continues.\n"
                 "Exit code: 0 done, 1 done but all frames are silent, 2 a wrong option or file.",
                 "midair-bake");
    addOptions(app, arguments, mode);
    int status = EXIT_DONE;
    return parseTool(app, argc, argv, status) ? work(arguments, mode) : status;
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
        std::fprintf(stderr, "midair-bake: %s\n", error.what());
        return EXIT_WRONG;
    }
}