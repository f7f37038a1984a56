#include "haptics/solvers/HologramSolver.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/base/text/Range.h"
#include "haptics/solvers/SolverSettings.h"
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
    base::RangeCheck check("solver option ");
    return solverSettings()
        .check(*this, check)
        .atLeast("skipTolerance", skipTolerance, 0.0)
        .above("updateRate_Hz", updateRate_Hz, 0.0)
        .passed(error);
}

const Eigen::VectorXf& HologramSolver::achieved_Pa() const
{
    static const Eigen::VectorXf kUnknown;
    return kUnknown;
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
    throw base::CodedError(
        base::MessageCode::SOLVER_UNKNOWN,
        fmt::format("unknown solver '{}'; known are {}", name, fmt::join(solverNames(), ", ")));
}

} // namespace midair::haptics
