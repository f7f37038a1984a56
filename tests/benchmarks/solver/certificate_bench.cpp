// How tight and how fast the certificate is, and how far every method's field is from the best that
// exists: equal targets on a Fibonacci sphere in the octagonal prism, one thread, G, K and M
// included.
#include "haptics/base/InputError.h"
#include "haptics/base/simd/InstructionSet.h"
#include "haptics/propagation/kernels/PropagationKernels.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/solvers/certificate/Certificate.h"
#include "tests/benchmarks/Timing.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <cstdio>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

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
    bool solvers = false;
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

} // namespace

int main(int argc, char** argv)
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
    CLI11_PARSE(app, argc, argv);
    try
    {
        printCertificates(arguments);
        if (arguments.solvers) printSolvers(arguments);
    }
    catch (const midair::base::InputError& error)
    {
        std::fprintf(stderr, "midair-certificate-bench: %s\n", error.what());
        return 2;
    }
    return 0;
}
