#pragma once

#include "haptics/HologramSolver.h"

#include <memory>

/// One function a method; makeSolver finds them by name.
namespace midair::haptics
{

/// "gs": Inoue, Makino, Shinoda 2015, Algorithm 1.
std::unique_ptr<HologramSolver> makeGerchbergSaxton(const SolverOptions& options);
/// "sdp-bcd": the same, Algorithm 2, with u projected to unit phases.
std::unique_ptr<HologramSolver> makeSdpBlockCoordinate(const SolverOptions& options);

} // namespace midair::haptics
