#pragma once

#include <osgMidair/FieldSolver>

#include <string>
#include <vector>

namespace osgMidair
{

/// The solvers that the application registered. From any thread.
struct SolverRegistry
{
    /// Returns what makes the solver \a name; empty if none of that name was registered.
    static FieldSolverFactory find(const std::string& name);
    static std::vector<std::string> names();
};

} // namespace osgMidair
