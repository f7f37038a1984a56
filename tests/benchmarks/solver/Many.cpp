#include "tests/benchmarks/solver/Many.h"

#include "haptics/base/Units.h"
#include "haptics/base/simd/InstructionSet.h"
#include "haptics/solvers/many/ManyFields.h"
#include "tests/benchmarks/Timing.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

using namespace midair;
using haptics::ManyFields;
using haptics::TransducerArray;

namespace midair::bench
{

namespace
{

constexpr double kStep_m = 0.5e-3;
constexpr int kPathLength = 250;

/// One line of the table.
struct Case
{
    const char* name;
    const TransducerArray* array;
    int points, fields;
    double tolerance;
    bool isCold;
    double wanted;         ///< fields per second on one core with AVX-512; 0: nothing is wanted
    bool fades = false;    ///< every other point fades to 0 and back within 200 fields
    double height_m = 0.0; ///< of the points' middle
};

/// Figures that others publish for their own programs, on their own hardware.
struct Published
{
    const char *what, *hardware, *figure, *source;
};

constexpr Published kPublished[] = {
    {"GS-PAT, up to 32 points, 512 transducers",
     "NVIDIA GTX 1660",
     "17,000 fields/s",
     "Plasencia et al. 2020, doi 10.1145/3386569.3392492"},
    {"AUTD3 SDK, GS-PAT in batches",
     "a GPU (wgpu)",
     "none",
     "its repository, changelog and manuals have benchmarks, but no figures"},
};

/// Two facing boards of 16 x 16 emitters at 10.5 mm, 239 mm apart: the levitators of the
/// literature, and of GS-PAT.
TransducerArray facingBoards()
{
    TransducerArray array = TransducerArray::singleBoard();
    array.name = "two facing boards";
    array.positions.resize(3, 512);
    array.normals.resize(3, 512);
    array.board.assign(512, 0);
    array.gain.resize(0);
    array.phaseOffset_rad.resize(0);
    for (int i = 0; i < 512; ++i)
    {
        const int upper = i / 256, row = i % 256 / 16, column = i % 16;
        array.positions.col(i) << 10.5e-3 * (column - 7.5), 10.5e-3 * (row - 7.5),
            upper ? 0.1195 : -0.1195;
        array.normals.col(i) << 0.0, 0.0, upper ? -1.0 : 1.0;
        array.board[static_cast<std::size_t>(i)] = upper;
    }
    return array;
}

/// Points on a sphere of 40 mm whose centre moves by kStep_m a field on a curve around the array's
/// middle.
std::vector<double> movingSphere(int fields, int points, double height_m)
{
    std::vector<double> positions;
    for (int field = 0; field < fields; ++field)
    {
        const double angle = field * kStep_m / 0.02;
        const double at[3] = {0.02 * std::cos(angle),
                              0.02 * std::sin(angle),
                              height_m + 0.006 * std::sin(2.0 * angle)};
        for (int l = 0; l < points; ++l)
        {
            const double z = 1.0 - 2.0 * (l + 0.5) / points, r = std::sqrt(1.0 - z * z);
            positions.push_back(at[0] + 0.04 * r * std::cos(2.399963 * l));
            positions.push_back(at[1] + 0.04 * r * std::sin(2.399963 * l));
            positions.push_back(at[2] + 0.04 * z);
        }
    }
    return positions;
}

/// Targets of fading points; without fading all are 1.
std::vector<double> targetsOf(const Case& one, int fields)
{
    std::vector<double> targets;
    for (int field = 0; field < fields; ++field)
        for (int l = 0; l < one.points; ++l)
            targets.push_back(one.fades && l % 2 == 1
                                  ? 0.5 * (1.0 + std::cos(base::kTwoPi * field / 200.0))
                                  : 1.0);
    return targets;
}

/// The rms error of one field in double precision, without anything that the solver uses: relative
/// to the targets, or to the largest if points fade.
double errorOf(const TransducerArray& array,
               const double* points,
               int n,
               const double* targets,
               bool fades,
               const std::uint8_t* phase)
{
    const haptics::Medium air;
    const double wavelength = air.wavelength(array.frequency_Hz);
    const double beta = air.attenuation(array.frequency_Hz);
    std::vector<double> pressures;
    double py = 0.0, pp = 0.0, square = 0.0;
    for (int l = 0; l < n; ++l)
    {
        std::complex<double> p = 0.0;
        for (int i = 0; i < array.size(); ++i)
        {
            const Eigen::Vector3d d =
                Eigen::Map<const Eigen::Vector3d>(points + 3 * l) - array.positions.col(i);
            const double R = d.norm(), cosine = d.dot(array.normals.col(i)) / R;
            const double offset = array.phaseOffset_rad.size() > 0 ? array.phaseOffset_rad[i] : 0.0;
            p += std::polar(haptics::directivity(array.directivity, cosine) / R *
                                std::exp(-beta * R),
                            offset + phase[i] * ManyFields::phaseStepOf_rad(array) -
                                base::kTwoPi * R / wavelength);
        }
        pressures.push_back(std::abs(p));
        py += pressures.back() * targets[l];
        pp += targets[l] * targets[l];
    }
    for (int l = 0; l < n; ++l)
        square += std::pow((pressures[static_cast<std::size_t>(l)] * pp / py - targets[l]) /
                               (fades ? 1.0 : targets[l]),
                           2);
    return std::sqrt(square / n);
}

/// Fields per second, the same per second of processor time, and errors of a case.
struct Outcome
{
    double perSecond = 0.0, perCore = 0.0, rms = 0.0, worst = 0.0, loudness = 0.0;
};

Outcome run(const Case& one, int threads, int repeats, bool inPaths)
{
    haptics::ManyFieldsOptions options;
    options.threads = threads;
    options.rmsTolerance = one.tolerance;
    options.fieldsInPath = one.isCold ? 1 : inPaths ? kPathLength : 0;
    ManyFields many(*one.array, {}, options);
    const int fields = one.fields * threads;
    const std::vector<double> positions = movingSphere(fields, one.points, one.height_m);
    std::vector<std::uint8_t> phases(static_cast<std::size_t>(fields) *
                                     static_cast<std::size_t>(one.array->size()));
    const std::vector<double> targets = targetsOf(one, fields);
    const haptics::ManyPoints points{
        fields, one.points, positions.data(), one.fades ? targets.data() : nullptr, false};
    Outcome outcome;
    for (int k = 0; k < repeats; ++k)
    {
        const double start_ms = wall_ms(), startCpu_ms = cpu_ms(CLOCK_PROCESS_CPUTIME_ID);
        many.solve(points, phases.data());
        outcome.perCore = std::max(outcome.perCore,
                                   1e3 * fields / (cpu_ms(CLOCK_PROCESS_CPUTIME_ID) - startCpu_ms));
        outcome.perSecond = std::max(outcome.perSecond, 1e3 * fields / (wall_ms() - start_ms));
    }
    std::vector<haptics::ManyFieldsFigures> figures(static_cast<std::size_t>(fields));
    many.solve(points, phases.data(), figures.data());
    const int every = std::max(1, fields / 20);
    int count = 0;
    for (int field = every - 1; field < fields; field += every, ++count)
    {
        const auto k = static_cast<std::size_t>(field);
        const double error =
            errorOf(*one.array,
                    positions.data() + 3 * k * static_cast<std::size_t>(one.points),
                    one.points,
                    targets.data() + k * static_cast<std::size_t>(one.points),
                    one.fades,
                    phases.data() + k * static_cast<std::size_t>(one.array->size()));
        outcome.rms += error * error;
        outcome.worst = std::max(outcome.worst, error);
    }
    outcome.rms = std::sqrt(outcome.rms / std::max(count, 1));
    for (const haptics::ManyFieldsFigures& figure : figures)
        outcome.loudness += static_cast<double>(figure.loudness) / fields;
    return outcome;
}

std::string processorName()
{
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);)
        if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
    return "unknown processor";
}

void printLine(const Case& one, const Outcome& outcome)
{
    std::printf("%-14s %6d %11d %6d %7.2f %% %10.0f %10.0f %6.3f %% %6.3f %% %6.3f %13.0f\n",
                one.name,
                one.points,
                one.array->size(),
                ManyFields::phaseLevelsOf(*one.array),
                100.0 * one.tolerance,
                outcome.perSecond,
                outcome.perCore,
                100.0 * outcome.rms,
                100.0 * outcome.worst,
                outcome.loudness,
                one.wanted);
    std::fflush(stdout);
}

/// The first case on up to all cores: fields per second of each core's time stay the same.
void printThreads(const Case& one, int repeats)
{
    const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    double alone = 0.0;
    for (int threads = 1; threads <= cores; ++threads)
    {
        const Outcome outcome = run(one, threads, repeats, true);
        if (threads == 1) alone = outcome.perCore;
        std::printf("%d threads, paths of %d fields: %.0f fields/s, %.0f a second of processor "
                    "time (%.2f of one "
                    "thread's)\n",
                    threads,
                    kPathLength,
                    outcome.perSecond,
                    outcome.perCore,
                    outcome.perCore / alone);
        std::fflush(stdout);
    }
}

} // namespace

void printMany(int threads, int repeats)
{
    const TransducerArray boards = facingBoards(), octagon = TransducerArray::octagonalPrism();
    const TransducerArray coarse[] = {TransducerArray::load("openmpd"),
                                      TransducerArray::load("sonicsurface"),
                                      TransducerArray::load("ultraino64")};
    const Case cases[] = {
        {"path", &boards, 32, 4000, 0.01, false, 50000},
        {"path", &boards, 32, 4000, 0.001, false, 30000},
        {"from nothing", &boards, 32, 1000, 0.01, true, 8000},
        {"path", &octagon, 4, 4000, 0.01, false, 60000},
        {"path", &octagon, 4, 4000, 0.001, false, 0},
        {"path", &octagon, 32, 1000, 0.01, false, 12000},
        {"path", &octagon, 32, 1000, 0.001, false, 0},
        {"from nothing", &octagon, 32, 200, 0.01, true, 0},
        {"fading", &boards, 32, 4000, 0.01, false, 0, true},
        {"path", &coarse[0], 4, 1000, 0.01, false, 0, false, 0.15},
        {"path", &coarse[1], 4, 1000, 0.01, false, 0, false, 0.15},
        {"path", &coarse[2], 2, 1000, 0.01, false, 0, false, 0.15},
    };
    std::printf("%s, %s, %d threads; steps of %.1f mm; errors in double "
                "precision\n",
                processorName().c_str(),
                base::instructionSetName(base::instructionSet()),
                threads,
                1e3 * kStep_m);
    std::printf("%-14s %6s %11s %6s %9s %10s %10s %8s %8s %6s %13s\n",
                "fields",
                "points",
                "transducers",
                "phases",
                "rms asked",
                "fields/s",
                "a core",
                "rms",
                "worst",
                "E",
                "wanted a core");
    for (const Case& one : cases)
        printLine(one, run(one, threads, repeats, threads > 1));
    printThreads(cases[0], repeats);
    std::printf("published by others:\n");
    for (const Published& one : kPublished)
        std::printf("%-42s %-16s %-16s (%s)\n", one.what, one.hardware, one.figure, one.source);
}

} // namespace midair::bench
