// Solves an animation beforehand, as accurately as the kit can, on one core or on many machines,
// and writes a recording that any device plays.
#include "haptics/base/InputError.h"
#include "haptics/base/Percentile.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Quantity.h"
#include "haptics/base/threads/SteadyClock.h"
#include "samples/shared/SettingOptions.h"
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

/// What a shard's frames have become, for the last line.
struct Baked
{
    std::uint64_t frames = 0;
    std::uint64_t fields = 0;
    std::uint64_t silent = 0; ///< frames
    std::uint64_t silenced = 0;
    double worstRms = 0.0;
    std::uint64_t points = 0; ///< most of a frame
};

/// Throws base::InputError, where the solver gave what no recording can have.
void addTo(RecordingWriter& writer, const BakedField& field)
{
    if (!writer.record(field)) throw base::InputError("a field doesn't fit the recording");
}

/// Solves a chunk from nothing. A payload is a recording by itself.
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
    std::printf("%llu frames, %llu fields; at most %llu points, rms error at most %.3f %%\n",
                static_cast<unsigned long long>(baked.frames),
                static_cast<unsigned long long>(baked.fields),
                static_cast<unsigned long long>(baked.points),
                100.0 * baked.worstRms);
    if (baked.silent > 0)
        std::printf("%llu of these frames are silent, %llu of them by caps\n",
                    static_cast<unsigned long long>(baked.silent),
                    static_cast<unsigned long long>(baked.silenced));
}

constexpr int kLevels = 256;
constexpr int kMostTransducers = 1 << 20;                     // of a recording
constexpr std::uint64_t kMostPlayed = std::uint64_t(2) << 30; // bytes of what play: takes

std::string framesOf(const nlohmann::json& work, std::uint64_t piece)
{
    const auto first = work.value("firstFrame", std::int64_t(0));
    const auto end = work.value("endFrame", std::int64_t(0));
    const auto chunk = work.value("chunk", std::int64_t(1));
    const std::int64_t begin = first + static_cast<std::int64_t>(piece) * chunk;
    return fmt::format("frames {} to {}", begin, std::min(begin + chunk, end) - 1);
}

/// Returns by how many levels all phases of \a next are to be turned, which can't be felt, so that
/// the drive changes least from \a last: argmax over r of Re sum a a' e^{j 2 pi (next + r -
/// last)/256}, with amplitudes by the levels of duty.
int turnBetween(const BakedField& last, const BakedField& next)
{
    // Whole numbers up to here, so that the order of the sum doesn't matter.
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

/// Puts chunks behind each other.
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
            throw base::InputError(name + " is for another number of transducers");
        bool isFirst = true;
        BakedField field;
        while (reader->next(field))
        {
            if (!field.phase.empty())
            {
                // What starts from nothing has its phases by chance.
                if (isFirst) _turn = _last.phase.empty() ? 0 : turnBetween(_last, field);
                isFirst = false;
                for (std::uint8_t& phase : field.phase)
                    phase = static_cast<std::uint8_t>(phase + _turn);
                ++_fields;
            }
            addTo(*_writer, field);
            _last = field;
        }
        if (!reader->getError().empty()) throw base::InputError(name + " breaks off");
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
    BakedField _last; ///< without phases: silence
    int _turn = 0;
    std::uint64_t _fields = 0;
};

/// Joins \a parts to a recording. Throws base::InputError.
void mergeBaked(const std::vector<std::string>& parts, const std::string& out, bool overwrite)
{
    const JoinedParts joined(parts, framesOf);
    const nlohmann::json& work = joined.work();
    if (work.value("what", "") != "midair-bake 1")
        throw base::InputError(fmt::format("\"{}\" is no part of midair-bake, but of {}",
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
                     "midair-bake: play: takes recordings of at most 2 GiB; bake shorter ranges of "
                     "frames\n");
}

/// Solves a shard. With a single one (1/1) \a arguments.out becomes the recording, and what is done
/// is kept in a part beside it until then; else it is the part. Goes on with a part that is there.
/// Returns the program's exit code: 0, or 1 if nothing is felt in any of its frames. Throws
/// base::InputError.
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
            tell(fmt::format("\"{}\": {}; solved again", file, part.damage()));
        if (part.pieces() > 0)
            tell(fmt::format("\"{}\" has {} of {} chunks already, which are kept",
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

// What baking costs: a model for many fields, and how it grows with processes.

constexpr double kMany = 1e6;              // fields
constexpr double kPlayable = 2147483648.0; // bytes of a recording that play: takes

/// Processor time of this process, s.
double cpu_s()
{
    timespec now = {};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// What one process has taken.
struct Run
{
    double wall_s = 0.0;
    double cpu_s = 0.0;
};

/// A process that bakes one of the shards, in silence. It is this program, which has no threads
/// yet.
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

/// Bakes shards 1 to \a running of \a shards at the same time.
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
    if (failed) throw base::InputError("a process that baked has failed");
    return runs;
}

/// What a frame takes, by medians, and makes, by means.
struct FrameCost
{
    std::uint64_t frames = 0; ///< that were measured
    double start_s = 0.0;     ///< of a core; from nothing
    double update_s = 0.0;    ///< from the last frame
    double fields = 0.0;      ///< of a frame
    double fieldBytes = 0.0;
};

FrameCost costOfFrames(BakeScene& scene, const BakeArguments& arguments)
{
    FrameCost cost;
    cost.frames = std::min(arguments.frames(), static_cast<std::uint64_t>(arguments.chunk));
    // Some more starts from nothing than a chunk has, so that their time is known.
    const std::uint64_t between = std::max<std::uint64_t>(1, cost.frames / 4);
    std::vector<double> starts_s;
    std::vector<double> updates_s;
    const osg::ref_ptr<RecordingWriter> writer = new RecordingWriter(scene.transducers());
    writer->take(); // what a recording begins with
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

/// Solves some frames and prints what many cost: time of a processor core, bytes, and time on
/// several cores. Writes nothing.
void estimate(const BakeArguments& arguments)
{
    const double begin_s = cpu_s();
    BakeScene scene(arguments);
    const double load_s = cpu_s() - begin_s;
    const FrameCost cost = costOfFrames(scene, arguments);
    std::printf("measured on %llu frames, medians, one process with %d %s\n"
                "  load the scene                  %8.0f ms of a core, once a process\n"
                "  a frame that starts a chunk     %8.2f ms of a core\n"
                "  each other frame                %8.2f ms of a core\n"
                "  fields in a frame               %8.2f\n"
                "  bytes of a field                %8.0f\n",
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
    std::printf("model: time of a core for N frames = N (%.2f ms + %.2f ms / %d), and %.0f ms a "
                "process\n"
                "10^6 fields\n"
                "  on one core                     %8.2f h\n"
                "  on 64 cores                     %8.2f h\n"
                "  in a file of                    %8.2f GB%s\n",
                1e3 * cost.update_s,
                1e3 * (cost.start_s - cost.update_s),
                arguments.chunk,
                1e3 * load_s,
                cost_h(1.0),
                cost_h(64.0),
                1e-9 * kMany * cost.fieldBytes,
                isTooLong ? "; play: takes 2 GiB, so bake ranges of frames" : "");
}

/// Bakes with one process and with \a processes at the same time, \a repeats times in turn, and
/// prints throughput and time of a processor core for each field.
void measureScaling(const BakeArguments& arguments, int processes, int repeats)
{
    std::string folder = (std::filesystem::temp_directory_path() / "midair-bake-XXXXXX").string();
    if (!::mkdtemp(folder.data())) throw base::InputError("can't make a folder " + folder);
    // Shard 1 alone, then all of them at the same time; each does a share of the same chunks.
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
            std::printf("  %2d  1 process: %7.2f ms of a core a frame, %7.1f frames/s;  %d: %7.2f "
                        "ms, %7.1f frames/s\n",
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
    std::printf("medians of %d: a frame takes %.2f ms of a core with 1 process, %.2f ms with %d\n"
                "  by the time of cores   %.3f of linear\n"
                "  by the clock           %.3f of linear (others' work on this machine counts)\n",
                repeats,
                base::percentile(single_ms, 0.5),
                base::percentile(together_ms, 0.5),
                processes,
                base::percentile(ratios, 0.5),
                base::percentile(throughput, 0.5));
}

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

int work(BakeArguments& arguments, const Mode& mode)
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

constexpr int kWrong = 2; // exit code

int run(int argc, char** argv)
{
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
        return work(arguments, mode);
    }
    catch (const CLI::ParseError& error)
    {
        return app.exit(error) == 0 ? 0 : kWrong;
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
        std::fprintf(stderr, "midair-bake: %s\n", error.what());
        return kWrong;
    }
}