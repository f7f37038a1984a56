#pragma once

#include "haptics/solvers/HologramSolver.h"

#include <memory>

/// One function per method; makeSolver() selects by name.
namespace midair::haptics
{

/// "gauss-newton": the production solver.
std::unique_ptr<HologramSolver> makeGaussNewton(const SolverOptions& options);
/// "gs": Inoue, Makino, Shinoda 2015, Algorithm 1.
std::unique_ptr<HologramSolver> makeGerchbergSaxton(const SolverOptions& options);
/// "sdp-bcd": Algorithm 2 of the same paper, with the entries of u projected to modulus 1.
std::unique_ptr<HologramSolver> makeSdpBlockCoordinate(const SolverOptions& options);

/// "gs-pat": Plasencia et al. 2020.
std::unique_ptr<HologramSolver> makeGsPat(const SolverOptions& options);
/// "wgs": weighted Gerchberg-Saxton, Marzo and Drinkwater 2019.
std::unique_ptr<HologramSolver> makeWeightedGerchbergSaxton(const SolverOptions& options);
/// "greedy": Suzuki et al. 2021.
std::unique_ptr<HologramSolver> makeGreedy(const SolverOptions& options);
/// "lbfgs": a quasi-Newton method for the transducers' phases.
std::unique_ptr<HologramSolver> makeLbfgs(const SolverOptions& options);

} // namespace midair::haptics
