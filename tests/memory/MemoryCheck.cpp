// midair-memory-check: solves cold and warm under deadlines that end a solve at every stage, and
// asks the memory sanitizer whether each number of each field was ever set. Prints nothing if all
// is well, but a line at the end; the sanitizer ends the program where a branch depends on what
// never was set.
#include "haptics/array/TransducerArray.h"
#include "haptics/base/UserEnvironment.h"
#include "haptics/solvers/HologramSolver.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <optional>
#include <string>
#include <vector>

#include <sanitizer/msan_interface.h>

// Returned by a library that the sanitizer doesn't see, so it would take these times for unset.
namespace std::chrono::_V2
{

steady_clock::time_point steady_clock::now() noexcept
{
    timespec time{};
    clock_gettime(CLOCK_MONOTONIC, &time);
    return time_point(seconds(time.tv_sec) + nanoseconds(time.tv_nsec));
}

} // namespace std::chrono::_V2

// Reads a file, through the same library. Nobody chooses the instruction set here: there is one.
std::optional<std::string> midair::base::userVariable(const std::string&)
{
    return std::nullopt;
}

using namespace midair::haptics;

namespace
{

int fields = 0;
int brokenOff = 0; // of these by the deadline

// 256 transducers at 10 mm in the plane z = 0 with a device's levels: the kit's own arrays are made
// with trees, of which the C++ library sets the nodes.
TransducerArray board()
{
    constexpr int kSide = 16;
    TransducerArray array;
    array.positions.resize(3, kSide * kSide);
    array.normals = Eigen::Vector3d::UnitZ().replicate(1, kSide * kSide);
    for (int i = 0; i < kSide * kSide; ++i)
        array.positions.col(i) =
            0.01 * Eigen::Vector3d(i % kSide - 0.5 * kSide, i / kSide - 0.5 * kSide, 0.0);
    array.board.assign(kSide * kSide, 0);
    array.drive.phaseLevels = 256;
    for (int level = 0; level < 256; ++level)
        array.drive.amplitudeLevels.push_back(static_cast<float>(level) / 255.0f);
    return array;
}

// Ends the program with the sanitizer's report if a number of the result was never set.
void requireSet(const Eigen::VectorXcf& q, const SolveReport& report)
{
    __msan_check_mem_is_initialized(
        q.data(), sizeof(std::complex<float>) * static_cast<std::size_t>(q.size()));
    for (const auto& [name, value] : figuresOf(report))
        __msan_check_mem_is_initialized(&value, sizeof value);
    ++fields;
    brokenOff += report.stop == StopReason::DEADLINE ? 1 : 0;
}

// A cold start, then moves: small ones, one that is skipped, one far off, and other points.
void solveOnce(const std::string& name, int n, bool absolute, const SolverOptions& options)
{
    static const TransducerArray array = board();
    const auto solver = makeSolver(name, options);
    Eigen::VectorXcf q;
    int points = n;
    for (const double place_m : {0.0, 1e-4, 1e-4, 1.1e-3, 0.03, 0.03})
    {
        ControlPoints scene = spherePoints(points, 0.02, {place_m, 0.0, 0.12});
        scene.absolute = absolute;
        if (absolute) scene.targets *= 200.0;
        requireSet(q, solver->solve(scene, array, Medium(), q));
        if (place_m == 0.03) points = n / 2 + 1;
    }
}

} // namespace

int main()
{
    // From what not even the matrix is built in to as long as it takes, in steps that end a solve
    // at every stage: this build is some thirty times slower than what users have.
    std::vector<double> deadlines_ms = {0.0};
    for (double deadline_ms = 0.01; deadline_ms < 1000.0; deadline_ms *= 1.2)
        deadlines_ms.push_back(deadline_ms);
    for (const double deadline_ms : deadlines_ms)
        for (const int n : {1, 5, 24})
            for (const bool absolute : {false, true})
            {
                SolverOptions options;
                options.deadline_ms = deadline_ms;
                solveOnce(solverNames().front(), n, absolute, options);
                options.phaseOnly = false;
                options.loudness = absolute ? 1.0 : 1.5;
                solveOnce(solverNames().front(), n, absolute, options);
            }
    for (const std::string& name : solverNames())
        for (const double deadline_ms : {0.0, 0.1, 10.0})
        {
            SolverOptions options;
            options.deadline_ms = deadline_ms;
            options.threads = 2;
            solveOnce(name, 9, false, options);
        }
    std::printf(
        "every number of %d fields and their figures was set; %d of them were broken off by "
        "their deadline\n",
        fields,
        brokenOff);
    const bool isBoth = brokenOff > 0 && brokenOff < fields;
    if (!isBoth)
        std::fprintf(stderr, "midair-memory-check: the deadlines don't suit this machine\n");
    return isBoth ? EXIT_SUCCESS : EXIT_FAILURE;
}
