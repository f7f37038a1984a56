#include "haptics/solvers/HologramSolver.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/text/Range.h"
#include "haptics/solvers/Solvers.h"

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

struct NamedSolver
{
    const char* name;
    std::unique_ptr<HologramSolver> (*make)(const SolverOptions&);
};

constexpr NamedSolver kSolvers[] = {
    {"gauss-newton", makeGaussNewton},
    {"gs", makeGerchbergSaxton},
    {"sdp-bcd", makeSdpBlockCoordinate},
    {"gs-pat", makeGsPat},
    {"wgs", makeWeightedGerchbergSaxton},
    {"greedy", makeGreedy},
    {"lbfgs", makeLbfgs},
};

} // namespace

bool SolverOptions::isValid(std::string* error) const
{
    return base::RangeCheck("solver option ")
        .atLeast("maxIterations", maxIterations, 0)
        .atLeast("rmsTolerance", rmsTolerance, 0.0)
        .atLeast("deadline_ms", deadline_ms, 0.0)
        .atLeast("lambdaRel", lambdaRel, 0.0)
        .check(loudness > 0.0 && loudness <= base::kMostLoudness,
               "loudness",
               loudness,
               "over 0 and at most 2")
        .within("threads", threads, 1, base::kMostThreads)
        .atLeast("skipTolerance", skipTolerance, 0.0)
        .atLeast("maxPhaseStep_rad", maxPhaseStep_rad, 0.0)
        .within("maxAmplitudeStep", maxAmplitudeStep, 0.0, 1.0)
        .above("updateRate_Hz", updateRate_Hz, 0.0)
        .passed(error);
}

std::vector<std::string> solverNames()
{
    std::vector<std::string> names;
    for (const NamedSolver& solver : kSolvers)
        names.emplace_back(solver.name);
    return names;
}

std::unique_ptr<HologramSolver> makeSolver(const std::string& name, const SolverOptions& options)
{
    std::string why;
    if (!options.isValid(&why)) throw base::InputError(why);
    for (const NamedSolver& solver : kSolvers)
        if (name == solver.name) return solver.make(options);
    throw base::InputError(
        fmt::format("unknown solver '{}'; known are {}", name, fmt::join(solverNames(), ", ")));
}

} // namespace midair::haptics
