#pragma once

#include "haptics/solvers/HologramSolver.h"

#include <memory>
#include <string>

namespace osgMidair
{

/// Makes the solver \a name: one that the application registered, else one of the kit's. Throws
/// midair::base::InputError, with the known names, if there is none.
std::unique_ptr<midair::haptics::HologramSolver>
makeAnySolver(const std::string& name, const midair::haptics::SolverOptions& options);

} // namespace osgMidair
