#include "tests/benchmarks/solver/Compare.h"

#include "haptics/base/InputError.h"
#include "tests/benchmarks/Timing.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <fcntl.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace midair::bench
{

namespace
{

/// What one block of one build came to.
struct Block
{
    std::string machine, isa;
    double time_ms = 0.0, roofline_ms = 0.0;
    double rms = 0.0, loudness = 0.0;
};

/// All blocks of one build for one cell.
struct Side
{
    std::vector<Block> blocks;

    double medianOf(double Block::*figure) const
    {
        std::vector<double> values;
        for (const Block& block : blocks)
            values.push_back(block.*figure);
        return median(values);
    }
    /// Of each block's time over the roofline that it measured itself.
    double multiple() const
    {
        std::vector<double> values;
        for (const Block& block : blocks)
            if (block.roofline_ms > 0.0) values.push_back(block.time_ms / block.roofline_ms);
        return median(values);
    }
};

std::vector<std::string> argumentsOf(const Cell& cell, const std::string& json)
{
    std::vector<std::string> arguments = {"--case",
                                          cell.kase,
                                          "--n",
                                          std::to_string(cell.points),
                                          "--radius",
                                          fmt::format("{}", cell.radius_m),
                                          "--mode",
                                          cell.mode,
                                          "--threads",
                                          std::to_string(cell.threads),
                                          "--repeats",
                                          std::to_string(cell.repeats),
                                          "--no-surface",
                                          "--json",
                                          json};
    const auto add = [&](const std::string& name, const std::string& value) {
        arguments.insert(arguments.end(), {name, value});
    };
    if (!cell.solver.empty()) add("--solver", cell.solver);
    if (cell.iterations > 0) add("--iterations", std::to_string(cell.iterations));
    if (cell.loudness != 1.0) add("--loudness", fmt::format("{}", cell.loudness));
    if (cell.unequal) arguments.push_back("--unequal");
    return arguments;
}

// Runs a program, without a shell, and waits for its end; what it prints is not shown.
void runQuietly(const std::string& program, std::vector<std::string> arguments)
{
    std::vector<char*> argv;
    std::string name = program;
    argv.push_back(name.data());
    for (std::string& argument : arguments)
        argv.push_back(argument.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    pid_t process = 0;
    const int error =
        ::posix_spawn(&process, program.c_str(), &actions, nullptr, argv.data(), environ);
    ::posix_spawn_file_actions_destroy(&actions);
    if (error != 0)
        throw base::InputError(fmt::format("cannot run {}: {}", program, std::strerror(error)));
    int status = 0;
    while (::waitpid(process, &status, 0) < 0 && errno == EINTR)
        continue;
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
        throw base::InputError(
            fmt::format("{} {} ended with {}; it must be a midair-bench",
                        program,
                        fmt::join(arguments, " "),
                        WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status)));
}

Block runBlock(const std::string& program, const Cell& cell, const std::string& json)
{
    std::filesystem::remove(json); // or a program that writes nothing leaves the last one's
    runQuietly(program, argumentsOf(cell, json));
    std::ifstream file(json);
    const nlohmann::json read = nlohmann::json::parse(file, nullptr, false);
    try
    {
        const nlohmann::json& result = read.at("results").at(0);
        // The processor time of other threads is not in cpu_ms.
        const double time_ms = result.at(cell.threads == 1 ? "cpu_ms" : "time_ms").get<double>();
        return {read.at("machine").get<std::string>(),
                read.at("isa").get<std::string>(),
                time_ms,
                result.at("roofline_ms").get<double>(),
                result.at("rms").get<double>(),
                result.at("loudness").get<double>()};
    }
    catch (const nlohmann::json::exception& error)
    {
        throw base::InputError(
            fmt::format("{} wrote no results that can be read: {}", program, error.what()));
    }
}

// Linear between the values on both sides; \a values not empty, ascending.
double quantile(const std::vector<double>& values, double share)
{
    const double at = share * static_cast<double>(values.size() - 1);
    const auto below = static_cast<std::size_t>(at);
    const std::size_t above = std::min(below + 1, values.size() - 1);
    return values[below] + (at - static_cast<double>(below)) * (values[above] - values[below]);
}

void print(const Cell& cell, const Side& fresh, const Side& old)
{
    std::vector<double> ratios;
    for (std::size_t k = 0; k < fresh.blocks.size(); ++k)
        ratios.push_back(fresh.blocks[k].time_ms / old.blocks[k].time_ms);
    std::sort(ratios.begin(), ratios.end());
    std::printf("%-8s %4d %3.0f %-6s  %8.3f %8.3f   %5.3f  %5.3f .. %5.3f  %5.3f .. %5.3f   %5.2f "
                "%5.2f   %8.4f %8.4f   %6.3f %6.3f\n",
                cell.kase.substr(cell.kase.find_last_of('/') + 1).c_str(),
                cell.points,
                1e3 * cell.radius_m,
                cell.mode.c_str(),
                fresh.medianOf(&Block::time_ms),
                old.medianOf(&Block::time_ms),
                quantile(ratios, 0.5),
                quantile(ratios, 0.25),
                quantile(ratios, 0.75),
                ratios.front(),
                ratios.back(),
                fresh.multiple(),
                old.multiple(),
                100.0 * fresh.medianOf(&Block::rms),
                100.0 * old.medianOf(&Block::rms),
                fresh.medianOf(&Block::loudness),
                old.medianOf(&Block::loudness));
    std::fflush(stdout);
}

void printHead(const Block& fresh, const Block& old, int rounds)
{
    std::printf("%s, %s", fresh.machine.c_str(), fresh.isa.c_str());
    if (old.isa != fresh.isa) std::printf(" (old: %s; the ratios compare both)", old.isa.c_str());
    std::printf("; %d rounds, medians; ms of processor time on one thread, else of the clock\n"
                "case        n  mm mode     ms: new      old   new/old:  quartiles       least .. "
                "most   xroof: new   old   rms %%: new    old    E: new    old\n",
                rounds);
}

/// A folder of this process's own, removed with what is in it.
class TemporaryFolder
{
public:
    TemporaryFolder()
    {
        _path = (std::filesystem::temp_directory_path() / "midair-bench-XXXXXX").string();
        if (::mkdtemp(_path.data()) == nullptr)
            throw base::InputError("cannot make the folder " + _path);
    }
    ~TemporaryFolder()
    {
        std::error_code ignored;
        std::filesystem::remove_all(_path, ignored);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    std::string file(const char* name) const { return _path + "/" + name; }

private:
    std::string _path;
};

} // namespace

void compare(const std::vector<Cell>& cells, const std::string& oldBinary, int rounds)
{
    const std::string self = std::filesystem::read_symlink("/proc/self/exe").string();
    const TemporaryFolder folder;
    const std::string json = folder.file("block.json");
    for (const Cell& cell : cells)
    {
        Side fresh, old;
        for (int round = 0; round < rounds; ++round)
            for (const bool isFresh : {round % 2 == 0, round % 2 != 0})
                (isFresh ? fresh : old)
                    .blocks.push_back(runBlock(isFresh ? self : oldBinary, cell, json));
        if (&cell == &cells.front()) printHead(fresh.blocks.front(), old.blocks.front(), rounds);
        print(cell, fresh, old);
    }
}

} // namespace midair::bench
