#include "haptics/base/InputError.h"
#include "haptics/base/text/PlainText.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/solvers/Solvers.h"

#include <cmath>
#include <cstdio>

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

bool fail(std::string* error, const char* name, double value, const char* range)
{
    if (error)
        *error = base::plainText("solver option %s is %g; it must be %s", name, value, range);
    return false;
}

} // namespace

bool SolverOptions::isValid(std::string* error) const
{
    const auto notNegative = [](double x) { return x >= 0.0 && std::isfinite(x); };
    if (maxIterations < 0) return fail(error, "maxIterations", maxIterations, ">= 0");
    if (!notNegative(rmsTolerance))
        return fail(error, "rmsTolerance", rmsTolerance, ">= 0 and finite");
    if (!notNegative(deadline_ms))
        return fail(error, "deadline_ms", deadline_ms, ">= 0 and finite");
    if (!notNegative(lambdaRel)) return fail(error, "lambdaRel", lambdaRel, ">= 0 and finite");
    if (!(loudness > 0.0 && loudness <= 2.0))
        return fail(error, "loudness", loudness, "over 0 and at most 2");
    if (threads < 1 || threads > 256) return fail(error, "threads", threads, "1 .. 256");
    if (!notNegative(skipTolerance))
        return fail(error, "skipTolerance", skipTolerance, ">= 0 and finite");
    if (!notNegative(maxPhaseStep_rad))
        return fail(error, "maxPhaseStep_rad", maxPhaseStep_rad, ">= 0 and finite");
    if (!(maxAmplitudeStep >= 0.0 && maxAmplitudeStep <= 1.0))
        return fail(error, "maxAmplitudeStep", maxAmplitudeStep, "0 .. 1");
    if (!(updateRate_Hz > 0.0 && std::isfinite(updateRate_Hz)))
        return fail(error, "updateRate_Hz", updateRate_Hz, "over 0 and finite");
    return true;
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
    std::string known;
    for (const NamedSolver& solver : kSolvers)
        known += (known.empty() ? "" : ", ") + std::string(solver.name);
    throw base::InputError("unknown solver '" + name + "'; known are " + known);
}

} // namespace midair::haptics
