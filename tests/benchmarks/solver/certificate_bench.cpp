// How tight and how fast the certificate is, and how far every method's field is from the best that
// exists: equal targets on a Fibonacci sphere in the octagonal prism, one thread, G, K and M
// included.
#include "haptics/base/simd/InstructionSet.h"
#include "haptics/points/FittedLevel.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/propagation/kernels/PropagationKernels.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/solvers/certificate/Certificate.h"
#include "tests/benchmarks/Timing.h"
#include "tests/haptics/solvers/LoudestSearch.h"
#include "tests/haptics/solvers/ScenePoints.h"
#include "tests/haptics/solvers/UnequalTargets.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

using namespace midair::haptics;
using midair::bench::cpu_ms;
using midair::bench::median;

namespace
{

struct Arguments
{
    std::vector<int> sizes{25, 50, 100, 200};
    double radius_m = 0.03;
    int repeats = 9;
    bool solvers = false, limits = false;
    CertificateOptions options;
};

struct Times
{
    std::vector<double> matrix, bound, search, total, cpu;

    void add(const Certificate& certificate)
    {
        matrix.push_back(certificate.matrix_ms);
        bound.push_back(certificate.bound_ms);
        search.push_back(certificate.search_ms);
        total.push_back(certificate.total_ms);
    }
};

void printCertificates(const Arguments& arguments)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    std::printf("# %s\n", midair::base::instructionSetName(midair::base::instructionSet()));
    std::printf("n,radius_m,bound,relaxed,best,gap_percent,rank,rounds,tight,matrix_ms,bound_ms,"
                "search_ms,total_ms,total_cpu_ms\n");
    for (const int n : arguments.sizes)
    {
        const ControlPoints points = spherePoints(n, arguments.radius_m);
        Certifier certifier(arguments.options);
        Times times;
        Certificate certificate;
        for (int i = 0; i < arguments.repeats; ++i)
        {
            const double start = cpu_ms();
            certificate = certifier.certify(points, array, Medium{});
            times.add(certificate);
            times.cpu.push_back(cpu_ms() - start);
        }
        std::printf("%d,%g,%.6g,%.6g,%.6g,%.3f,%d,%d,%d,%.2f,%.2f,%.2f,%.2f,%.2f\n",
                    n,
                    arguments.radius_m,
                    certificate.bound,
                    certificate.relaxed,
                    certificate.best,
                    100.0 * certificate.gap(),
                    certificate.rank,
                    certificate.rounds,
                    certificate.tight ? 1 : 0,
                    median(times.matrix),
                    median(times.bound),
                    median(times.search),
                    median(times.total),
                    median(times.cpu));
        std::fflush(stdout);
    }
}

void printSolvers(const Arguments& arguments)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    std::printf(
        "\nn,radius_m,solver,rms,loudness,phases_over_bound_percent,field_over_bound_percent\n");
    for (const int n : arguments.sizes)
    {
        const ControlPoints points = spherePoints(n, arguments.radius_m);
        Certifier certifier(arguments.options);
        for (const std::string& name : solverNames())
        {
            Eigen::VectorXcf q;
            const SolveReport report = makeSolver(name)->solve(points, array, Medium{}, q);
            const Certificate certificate = certifier.certify(points, array, Medium{}, q);
            std::printf("%d,%g,%s,%.3g,%.3f,%.2f,%.2f\n",
                        n,
                        arguments.radius_m,
                        name.c_str(),
                        report.rms,
                        report.loudness,
                        100.0 * certificate.gapOfPhases(),
                        100.0 * certificate.gapOfField());
            std::fflush(stdout);
        }
    }
}

constexpr int kMostSearched = 20; // points: the slow search has dense matrices

/// Points that are hard to meet.
struct Corner
{
    const char* name;
    ControlPoints points;
    TransducerArray array;
};

std::vector<Corner> corners()
{
    const TransducerArray octagon = TransducerArray::octagonalPrism();
    const double half_m = Medium().wavelength(40e3) / 2.0;
    std::vector<Corner> all = {
        {"octagon, 14 x 14 along the axis", gridPoints(14, 14, 1, half_m), octagon},
        {"octagon, 14 x 14 across the axis", gridPoints(14, 1, 14, half_m), octagon},
        {"octagon, 20 x 20 across the axis", gridPoints(20, 1, 20, half_m), octagon}};
    for (const double spacing_m : {0.015, 0.03})
        for (const int levels : {10, 256})
        {
            Corner corner{levels == 10 ? "ultraino64, 10 unequal targets"
                                       : "the same, 256 levels of phase",
                          tenUnequal(spacing_m),
                          TransducerArray::load("ultraino64")};
            corner.array.drive.phaseLevels = levels;
            all.push_back(std::move(corner));
        }
    return all;
}

// Returns an upper bound of E for exact fields: one of level s has |q|^2 <= m, so that
// bound <= u* M u <= lambda m/s^2, for any lambda.
double mostLoudness(const Corner& corner, const Eigen::MatrixXcd& K, double meanRowSum)
{
    double most = 1e9;
    for (const double lambdaRel : {0.3, 0.1, 0.03, 0.01})
    {
        CertificateOptions options;
        options.lambdaRel = lambdaRel;
        options.batches = 0;
        options.tolerance = 1e-2;
        const PhaseObjective objective(K, corner.points.targets, lambdaRel);
        const Certificate certificate = Certifier(options).certify(objective);
        const double s = std::sqrt(objective.lambda() * corner.array.size() / certificate.bound);
        most = std::min(most, loudnessOf(s, corner.points.targets.norm(), meanRowSum));
    }
    return most;
}

// What hard points leave of the array's freedom, and what the solver makes of it.
void printLimits()
{
    std::printf("free: singular values of G above a tenth of their rms; most E: of an exact field, "
                "certified; found E: the loudest exact field that a slow search finds\n"
                "%-34s %10s %5s %5s %7s %8s %7s %8s %8s\n",
                "points",
                "spacing mm",
                "n",
                "free",
                "most E",
                "found E",
                "E",
                "rms %",
                "ms");
    for (const Corner& corner : corners())
    {
        const Eigen::MatrixXcd G =
            referencePropagationMatrix(corner.points.positions, corner.array, Medium());
        const Eigen::MatrixXcd K = gramMatrix(G);
        const Eigen::VectorXd values =
            Eigen::SelfAdjointEigenSolver<Eigen::MatrixXcd>(K, Eigen::EigenvaluesOnly)
                .eigenvalues();
        Eigen::VectorXcf q;
        const double start_ms = cpu_ms();
        makeSolver("gauss-newton")->solve(corner.points, corner.array, Medium(), q);
        const double time_ms = cpu_ms() - start_ms;
        const Eigen::VectorXd y = (G * q.cast<std::complex<double>>()).cwiseAbs();
        const double s = fittedLevel(y, corner.points.targets);
        const double meanRowSum = G.cwiseAbs().rowwise().sum().mean();
        constexpr int kStarts = 50;
        const std::string found =
            corner.points.size() > kMostSearched
                ? "-"
                : fmt::format("{:.3f}",
                              loudnessOf(loudestExactLevel(G, corner.points.targets, kStarts),
                                         corner.points.targets.norm(),
                                         meanRowSum));
        std::printf("%-34s %10.1f %5d %5d %7.2f %8s %7.3f %8.3f %8.1f\n",
                    corner.name,
                    1e3 * (corner.points.positions.col(1) - corner.points.positions.col(0)).norm(),
                    corner.points.size(),
                    static_cast<int>((values.array() > 0.01 * values.mean()).count()),
                    mostLoudness(corner, K, meanRowSum),
                    found.c_str(),
                    loudnessOf(s, corner.points.targets.norm(), meanRowSum),
                    100.0 * relativeRms(y, corner.points.targets, s),
                    time_ms);
        std::fflush(stdout);
    }
}

int run(int argc, char** argv)
{
    Arguments arguments;
    CLI::App app(
        "Times the certificate, and prints how far every solver's field is from the bound.",
        "midair-certificate-bench");
    app.add_option("--n", arguments.sizes, "Numbers of control points")->capture_default_str();
    app.add_option("--radius", arguments.radius_m, "Radius of the sphere, metres")
        ->capture_default_str();
    app.add_option("--repeats", arguments.repeats, "Certificates, of which times are medians")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    app.add_option("--seed", arguments.options.seed)->capture_default_str();
    app.add_option(
           "--batches", arguments.options.batches, "Of rounded solutions, searched for phases")
        ->capture_default_str();
    app.add_option("--tolerance", arguments.options.tolerance, "Of the bound")
        ->capture_default_str();
    app.add_flag(
        "--solvers", arguments.solvers, "Compare every solver's field with the bound, too");
    app.add_flag("--limits", arguments.limits, "Only hard points, and how loud they can be");
    CLI11_PARSE(app, argc, argv);
    if (arguments.limits)
    {
        printLimits();
        return 0;
    }
    printCertificates(arguments);
    if (arguments.solvers) printSolvers(arguments);
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
        std::fprintf(stderr, "midair-certificate-bench: %s\n", error.what());
        return 1;
    }
}
