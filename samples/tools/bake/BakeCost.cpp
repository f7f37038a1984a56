// What baking costs: a model for many fields, and how it grows with processes.
#include "device/recording/Recording.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Percentile.h"
#include "haptics/base/threads/SteadyClock.h"
#include "samples/tools/bake/Bake.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ; // NOLINT(readability-redundant-declaration)

namespace midair::samples
{

namespace
{

namespace recording = device::recording;

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

/// A process that bakes one of the shards.
pid_t start(const BakeArguments& arguments,
            const std::string& program,
            int shard,
            int shards,
            const std::string& out)
{
    std::vector<std::string> words = {program,
                                      arguments.scene,
                                      "--frames",
                                      fmt::format("{}:{}", arguments.first, arguments.end),
                                      "--fps",
                                      fmt::format("{}", arguments.fps),
                                      "--chunk",
                                      std::to_string(arguments.chunk),
                                      "--threads",
                                      std::to_string(arguments.threads),
                                      "--shard",
                                      fmt::format("{}/{}", shard, shards),
                                      "--out",
                                      out,
                                      "--quiet"};
    if (!arguments.settings.empty()) words.insert(words.end(), {"--device", arguments.settings});
    if (!arguments.options.empty()) words.insert(words.end(), {"--options", arguments.options});
    if (arguments.withoutLive) words.emplace_back("--without-live");
    std::vector<char*> argv;
    for (std::string& word : words)
        argv.push_back(word.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    ::posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    pid_t child = -1;
    const int error =
        ::posix_spawn(&child, program.c_str(), &actions, nullptr, argv.data(), environ);
    ::posix_spawn_file_actions_destroy(&actions);
    if (error != 0) throw base::InputError("can't start " + program);
    return child;
}

/// Bakes all shards at the same time.
std::vector<Run> runAll(const BakeArguments& arguments,
                        const std::string& program,
                        int running,
                        int shards,
                        const std::string& folder)
{
    const double begin_s = base::steadySeconds();
    std::vector<pid_t> children;
    for (int shard = 1; shard <= running; ++shard)
    {
        const std::string out = fmt::format("{}/{}.part", folder, shard);
        std::filesystem::remove(out);
        children.push_back(start(arguments, program, shard, shards, out));
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
    recording::Writer writer(static_cast<int>(scene.transducers()));
    double bytes = 0.0;
    double fields = 0.0;
    for (std::uint64_t number = 0; number < cost.frames; ++number)
    {
        const bool isStart = number % between == 0;
        if (isStart) scene.restart();
        const double before_s = cpu_s();
        const osgMidair::BakedFrame frame = scene.bake(number);
        (isStart ? starts_s : updates_s).push_back(cpu_s() - before_s);
        for (const osgMidair::BakedField& field : frame.fields)
            bytes += static_cast<double>(
                (field.phase.empty() ? writer.mark(field.time_ns, recording::Kind::SILENCE)
                                     : writer.field(field.time_ns, {field.phase, field.duty}))
                    .size());
        fields += static_cast<double>(frame.fields.size());
    }
    cost.start_s = base::percentile(starts_s, 0.5);
    cost.update_s = updates_s.empty() ? cost.start_s : base::percentile(updates_s, 0.5);
    cost.fields = fields / static_cast<double>(cost.frames);
    cost.fieldBytes = bytes / fields;
    return cost;
}

} // namespace

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

void measureScaling(const BakeArguments& arguments,
                    int processes,
                    int repeats,
                    const std::string& program)
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
            const Run alone = runAll(arguments, program, 1, processes, folder).front();
            const std::vector<Run> all = runAll(arguments, program, processes, processes, folder);
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

} // namespace midair::samples
