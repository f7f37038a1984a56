#pragma once

#include "haptics/solvers/HologramSolver.h"

#include <osgMidair/FieldMethod>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Makes a solver; null counts as a solver that has no field.
using FieldMethodFactory = std::function<std::shared_ptr<FieldMethod>()>;

/// Registers the name \a name, 1 .. 32 small letters, digits and dashes, for the rest of the
/// program. Returns false, with the reason in \a error, if it has another form or is taken. From
/// any thread.
bool registerMethod(const std::string& name, FieldMethodFactory make, std::string& error);

/// Returns the names that were registered. From any thread.
std::vector<std::string> ownSolverNames();
/// True: \a name is one of them, so that a solve that it refuses has failed. From any thread.
bool isOwnSolver(const std::string& name);

/// Makes the solver \a name: one that the application registered, else one of haptics'. Throws
/// base::InputError, with the known names, if there is none.
std::unique_ptr<haptics::HologramSolver> makeAnySolver(const std::string& name,
                                                       const haptics::SolverOptions& options);

} // namespace midair::bridge
