#include "haptics/solvers/HologramSolver.h"
#include "plugin/extending/NamedFactories.h"
#include "plugin/extending/SolverRegistry.h"

#include <osgMidair/FieldSolver>

#include <utility>

namespace osgMidair
{

namespace
{

NamedFactories<FieldSolverFactory>& solverRegistry()
{
    static NamedFactories<FieldSolverFactory> all("solver");
    return all;
}

} // namespace

FieldSolverFactory SolverRegistry::find(const std::string& name)
{
    return solverRegistry().find(name);
}

std::vector<std::string> SolverRegistry::names()
{
    return solverRegistry().names();
}

bool registerSolver(const std::string& name, FieldSolverFactory make, std::string& error)
{
    return solverRegistry().add(name, std::move(make), midair::haptics::solverNames(), error);
}

} // namespace osgMidair
