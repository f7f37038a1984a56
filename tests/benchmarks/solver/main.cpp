// midair-bench: run time against error of every solver, point set and size, with the loudness that
// each reaches.
#include "haptics/base/InputError.h"
#include "haptics/base/simd/InstructionSet.h"
#include "haptics/propagation/kernels/PropagationKernels.h"
#include "haptics/solvers/HologramSolver.h"
#include "tests/benchmarks/solver/Cell.h"
#include "tests/benchmarks/solver/Compare.h"
#include "tests/benchmarks/solver/Many.h"
#include "tests/benchmarks/solver/Reflected.h"
#include "tests/benchmarks/solver/Rest.h"

#include <algorithm>
#include <cstdio>
#include <exception>

#include <CLI/CLI.hpp>

using namespace midair;
using bench::Cell;
using bench::Result;

namespace
{

struct Size
{
    int points;
    double radius_m;
};

const std::vector<Size> kSizes = {{25, 0.03}, {50, 0.03}, {100, 0.03}, {200, 0.06}, {400, 0.06}};
constexpr int kMostGreedyRounds = 5;

// The production solver's table, and every method's curve of time against error by its iteration
// limit.
std::vector<Cell> allCells(bool quick, const Cell& common)
{
    std::vector<Cell> cells;
    const std::vector<std::string> solvers = haptics::solverNames();
    for (const Size& size : kSizes)
    {
        if (quick && size.points != 25 && size.points != 100) continue;
        for (const std::string& solver : solvers)
        {
            for (const char* mode : {"update", "cold"})
            {
                if (quick && solver != solvers.front() && std::string(mode) == "update") continue;
                const std::vector<int> limits =
                    quick ? std::vector<int>{0}
                          : std::vector<int>{1, 2, 5, 10, 20, 50, 100, 200, 0};
                for (const int limit : limits)
                {
                    // A round of it visits every transducer in turn: seconds.
                    if (solver == "greedy" && limit > kMostGreedyRounds) continue;
                    Cell cell = common;
                    cell.points = size.points;
                    cell.radius_m = size.radius_m;
                    cell.solver = solver;
                    cell.mode = mode;
                    cell.iterations = limit;
                    cell.repeats = quick ? (solver == solvers.front() ? 9 : 1)
                                         : (solver == solvers.front() ? 41
                                            : size.points > 200       ? 3
                                                                      : 5);
                    cells.push_back(cell);
                }
            }
        }
    }
    // What loudness beyond 1 costs.
    for (const Size& size : kSizes)
        for (const double loudness : {1.1, 1.25, 1.5, 1.75, 2.0})
        {
            if (quick && (size.points != 25 || loudness != 1.5)) continue;
            Cell cell = common;
            cell.points = size.points;
            cell.radius_m = size.radius_m;
            cell.solver = solvers.front();
            cell.loudness = loudness;
            cell.repeats = 9;
            cells.push_back(cell);
        }
    for (const char* kase : {"star", "line"})
        for (const std::string& solver : solvers)
        {
            Cell cell = common;
            cell.kase = kase;
            cell.points = kase == std::string("star") ? 22 : 12;
            cell.radius_m = 0.05;
            cell.solver = solver;
            cell.mode = "cold";
            cell.repeats = quick ? 1 : 5;
            cells.push_back(cell);
        }
    return cells;
}

// The production solver's table in ACCURACY.md.
std::vector<Cell> productionCells(const Cell& common)
{
    std::vector<Cell> cells;
    for (const char* mode : {"update", "cold"})
        for (const Size& size : kSizes)
        {
            Cell cell = common;
            cell.points = size.points;
            cell.radius_m = size.radius_m;
            cell.mode = mode;
            cells.push_back(cell);
        }
    return cells;
}

void print(const Result& r)
{
    std::printf("%-8s n %3d r %.0f mm %-12s %-6s %d thr  %9.3f ms (cpu %.3f, x%.1f of %.3f)  rms "
                "%.4f %% (worst %.4f)  max "
                "%.3f %%  E %.3f (least %.3f)  it %d  matrix %.2f ns an entry  surface cv %.2f, "
                "contrast %.1f  gap %.2f %%\n",
                r.cell.kase.substr(r.cell.kase.find_last_of('/') + 1).c_str(),
                r.points,
                1e3 * r.cell.radius_m,
                r.cell.solver.c_str(),
                r.cell.mode.c_str(),
                r.cell.threads,
                r.time_ms,
                r.cpu_ms,
                r.roofline_ms > 0.0 ? r.cpu_ms / r.roofline_ms : 0.0,
                r.roofline_ms,
                100.0 * r.rms,
                100.0 * r.worstRms,
                100.0 * r.max,
                r.loudness,
                r.leastLoudness,
                r.iterations,
                1e6 * r.matrix_ms / (std::max(r.points, 1) * double(r.transducers)),
                r.last.surface.coefficientOfVariation,
                r.last.surface.contrast,
                100.0 * r.gap);
    std::fflush(stdout);
}

/// The command line.
struct Request
{
    Cell cell;
    std::string csv, json, oldBinary;
    bool quick = false, noSurface = false, many = false, rest = false, reflected = false;
    int rounds = 11;
};

void addOptions(CLI::App& app, Request& request)
{
    Cell& cell = request.cell;
    app.add_option(
        "--case", cell.kase, "sphere, star, line, or an OBJ file (sampled a wavelength apart)");
    app.add_option("--n", cell.points, "control points")->check(CLI::Range(1, 100000));
    app.add_option("--radius", cell.radius_m, "half the largest extent, metres")
        ->check(CLI::PositiveNumber);
    app.add_option("--solver", cell.solver, "a solver's name; the default solver if left out");
    app.add_option("--mode", cell.mode, "update or cold");
    app.add_option("--threads", cell.threads)->check(CLI::Range(1, 256));
    app.add_option("--iterations", cell.iterations, "limit; 0: the method's own");
    app.add_option("--repeats", cell.repeats)->check(CLI::Range(1, 1000000));
    app.add_flag("--unequal", cell.unequal, "targets from 0.3 to 1");
    app.add_option("--loudness", cell.loudness, "over 1: louder than it accurately can")
        ->check(CLI::Range(0.01, 2.0));
    app.add_flag("--no-surface", request.noSurface, "no figures over the surface, no bound");
    app.add_option("--csv", request.csv, "file to write");
    app.add_option("--json", request.json, "file to write");
    app.add_flag("--quick", request.quick, "a short version of everything");
    app.add_flag("--many", request.many, "fields per second of ManyFields, on --threads threads");
    app.add_flag("--rest", request.rest, "loudness, error and duration of fields at rest");
    app.add_flag(
        "--reflected",
        request.reflected,
        "updates in free air, above a plane and above a table, for --rounds rounds in turn");
    app.add_option("--compare",
                   request.oldBinary,
                   "another build's midair-bench: both run turn by turn, and ratios are printed")
        ->check(CLI::ExistingFile)
        ->excludes("--csv", "--json", "--quick");
    app.add_option("--rounds", request.rounds, "of --compare and --reflected: blocks of each kind")
        ->check(CLI::Range(1, 10000))
        ->capture_default_str();
}

void runAll(const std::vector<Cell>& cells, const Request& request)
{
    std::printf("%s, %zu cells\n", base::instructionSetName(base::instructionSet()), cells.size());
    std::vector<Result> results;
    for (const Cell& next : cells)
    {
        results.push_back(bench::run(next));
        print(results.back());
        // After every cell, so that a run that is broken off leaves what it had.
        if (!request.csv.empty()) bench::writeCsv(request.csv, results);
        if (!request.json.empty()) bench::writeJson(request.json, results);
    }
}

int run(int argc, char** argv)
{
    CLI::App app(
        "Run time against error of the hologram solvers (octagonal prism, 3984 transducers)");
    Request request;
    addOptions(app, request);
    CLI11_PARSE(app, argc, argv);
    Cell& cell = request.cell;
    if (request.many)
    {
        bench::printMany(cell.threads, app.count("--repeats") > 0 ? cell.repeats : 5);
        return 0;
    }
    if (request.rest)
    {
        bench::printRest();
        return 0;
    }
    const bool one =
        !request.quick && (app.count("--case") + app.count("--n") + app.count("--radius") +
                               app.count("--solver") + app.count("--mode") >
                           0);
    if (request.reflected)
    {
        if (app.count("--repeats") == 0) cell.repeats = 15;
        if (cell.solver.empty()) cell.solver = haptics::solverNames().front();
        bench::printReflected(one ? std::vector<Cell>{cell} : productionCells(cell),
                              request.rounds);
        return 0;
    }
    if (!request.oldBinary.empty())
    {
        // A block is short, so that a machine that slows down slows a whole round.
        if (app.count("--repeats") == 0) cell.repeats = 15;
        bench::compare(one ? std::vector<Cell>{cell} : productionCells(cell),
                       request.oldBinary,
                       request.rounds);
        return 0;
    }
    cell.surface = !request.noSurface;
    if (cell.solver.empty()) cell.solver = haptics::solverNames().front();
    runAll(one ? std::vector<Cell>{cell} : allCells(request.quick, cell), request);
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
        std::fprintf(stderr, "midair-bench: %s\n", error.what());
        return 1;
    }
}
