#pragma once

#include "haptics/solvers/HologramSolver.h"

#include <osgMidair/FieldMethod>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Makes a solver; null counts as a solver without a field.
using FieldMethodFactory = std::function<std::shared_ptr<FieldMethod>()>;

/// Registers \a name, 1 .. 32 small letters, digits and dashes, for the rest of the program.
/// Returns false, with the reason in \a error, if it is malformed or taken. Any thread.
bool registerMethod(const std::string& name, FieldMethodFactory make, std::string& error);

/// Returns the registered names. Any thread.
std::vector<std::string> ownSolverNames();
/// True if \a name is registered, so that a refused solve counts as failed. Any thread.
bool isOwnSolver(const std::string& name);

/// Makes the solver \a name, registered by the application or one of the kit's. Throws
/// base::InputError, with the known names, if there is none.
std::unique_ptr<haptics::HologramSolver> makeAnySolver(const std::string& name,
                                                       const haptics::SolverOptions& options);

} // namespace midair::bridge
