// midair-cold-bench: from the start of a process to its first field: loading libmidair, the array,
// and solving. A new process each time; medians of the wall and of the processor's time, because
// other programs lengthen the former.
#include "tests/benchmarks/Timing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <dlfcn.h>
#include <midair.h>
#include <sys/resource.h>
#include <unistd.h>

using namespace midair;

namespace
{

enum Stage
{
    LIBRARY, ///< from the start of the process until the library is loaded
    ARRAY,
    FIELD,  ///< from nothing, as midair_solve() gives it to a program
    SECOND, ///< the same once more, by a new solver; not part of the sum
    STAGES
};

constexpr std::array<const char*, STAGES> kNames = {
    "process, library", "array", "first field", "another field"};

/// What a stage took.
struct Cost
{
    double wall_ms = 0.0, cpu_ms = 0.0;
    long faults = 0; ///< pages touched first

    Cost operator-(const Cost& before) const
    {
        return {wall_ms - before.wall_ms, cpu_ms - before.cpu_ms, faults - before.faults};
    }
};

Cost now()
{
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return {bench::wall_ms(), bench::cpu_ms(CLOCK_PROCESS_CPUTIME_ID), usage.ru_minflt};
}

template<typename Function>
Function* named(void* library, const char* name)
{
    void* const found = dlsym(library, name);
    if (found == nullptr)
    {
        std::fprintf(stderr, "midair-cold-bench: %s\n", dlerror());
        std::exit(1);
    }
    return reinterpret_cast<Function*>(found);
}

/// The work of a child, which began at \a start_ms.
void child(double start_ms, const std::string& arrayName, int points)
{
    std::vector<Cost> at{{start_ms, 0.0, 0}};
    void* const library = dlopen(MIDAIR_LIBRARY, RTLD_NOW | RTLD_LOCAL);
    const auto check = [](bool isDone, const char* what)
    {
        if (isDone) return;
        std::fprintf(stderr, "midair-cold-bench: %s failed\n", what);
        std::exit(1);
    };
    check(library != nullptr, "loading the library");
    at.push_back(now());
    midair_array* array = nullptr;
    midair_scene* scene = nullptr;
    midair_object object = 0;
    check(named<decltype(midair_array_load)>(library, "midair_array_load")(arrayName.c_str(),
                                                                           &array) == MIDAIR_OK,
          "loading the array");
    at.push_back(now());
    std::vector<double> positions;
    for (int l = 0; l < points; ++l) // on a sphere of 30 mm
    {
        const double z = 1.0 - 2.0 * (l + 0.5) / points, r = std::sqrt(1.0 - z * z);
        positions.push_back(0.03 * r * std::cos(2.399963 * l));
        positions.push_back(0.03 * r * std::sin(2.399963 * l));
        positions.push_back(0.03 * z);
    }
    check(named<decltype(midair_scene_make)>(library, "midair_scene_make")(array, &scene) ==
                  MIDAIR_OK &&
              named<decltype(midair_add_points)>(library, "midair_add_points")(
                  scene, positions.data(), nullptr, positions.size() / 3, 0, &object) == MIDAIR_OK,
          "making the scene");
    for (int k = 0; k < 2; ++k)
    {
        midair_field* field = nullptr;
        check(named<decltype(midair_solve)>(library, "midair_solve")(scene, &field) == MIDAIR_OK,
              "solving");
        named<decltype(midair_field_close)>(library, "midair_field_close")(field);
        at.push_back(now());
    }
    for (std::size_t stage = 0; stage < STAGES; ++stage)
    {
        const Cost cost = at[stage + 1] - at[stage];
        std::printf("%.6f %.6f %ld\n", cost.wall_ms, cost.cpu_ms, cost.faults);
    }
    std::fflush(stdout);
}

/// Runs a child and reads its costs.
std::array<Cost, STAGES> measured(const std::string& array, int points)
{
    std::array<char, 4096> path{};
    if (readlink("/proc/self/exe", path.data(), path.size() - 1) < 0) std::exit(1);
    char start[64];
    std::snprintf(start, sizeof start, "%.6f", bench::wall_ms());
    const std::string line = std::string("exec ") + path.data() + " --child " + start +
                             " --array " + array + " --points " + std::to_string(points);
    std::FILE* const out = popen(line.c_str(), "r");
    std::array<Cost, STAGES> costs{};
    bool isRead = out != nullptr;
    for (Cost& cost : costs)
        isRead = isRead &&
                 std::fscanf(out, "%lf %lf %ld", &cost.wall_ms, &cost.cpu_ms, &cost.faults) == 3;
    if (out == nullptr || pclose(out) != 0 || !isRead)
    {
        std::fprintf(stderr, "midair-cold-bench: a child failed\n");
        std::exit(1);
    }
    return costs;
}

void printLine(const char* name, const std::vector<Cost>& all)
{
    std::vector<double> wall_ms, cpu_ms, faults;
    for (const Cost& cost : all)
    {
        wall_ms.push_back(cost.wall_ms);
        cpu_ms.push_back(cost.cpu_ms);
        faults.push_back(static_cast<double>(cost.faults));
    }
    std::printf("%-18s %9.1f %9.1f %9.0f\n",
                name,
                bench::median(wall_ms),
                bench::median(cpu_ms),
                bench::median(faults));
}

int run(int argc, char** argv)
{
    CLI::App app("From the start of a process to its first field, in new processes");
    double start_ms = 0.0;
    std::string array = "octagon";
    int points = 100, processes = 41;
    app.add_option("--array", array, "name")->capture_default_str();
    app.add_option("--points", points)->check(CLI::Range(1, 1000))->capture_default_str();
    app.add_option("--processes", processes)->check(CLI::Range(1, 10000))->capture_default_str();
    app.add_option("--child", start_ms, "for this program itself");
    CLI11_PARSE(app, argc, argv);
    if (app.count("--child") > 0)
    {
        child(start_ms, array, points);
        return 0;
    }
    std::array<std::vector<Cost>, STAGES> all;
    std::vector<Cost> sums;
    for (int k = 0; k < processes; ++k)
    {
        const std::array<Cost, STAGES> costs = measured(array, points);
        Cost sum;
        for (std::size_t stage = 0; stage < STAGES; ++stage)
        {
            all[stage].push_back(costs[stage]);
            if (stage == SECOND) continue;
            sum.wall_ms += costs[stage].wall_ms;
            sum.cpu_ms += costs[stage].cpu_ms;
            sum.faults += costs[stage].faults;
        }
        sums.push_back(sum);
    }
    std::printf("%s, %d points, medians of %d processes\n", array.c_str(), points, processes);
    std::printf("%-18s %9s %9s %9s\n", "", "wall ms", "cpu ms", "faults");
    for (std::size_t stage = 0; stage < SECOND; ++stage)
        printLine(kNames[stage], all[stage]);
    printLine("together", sums);
    printLine(kNames[SECOND], all[SECOND]);
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
        std::fprintf(stderr, "midair-cold-bench: %s\n", error.what());
        return 1;
    }
}
