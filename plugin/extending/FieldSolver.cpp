#include "haptics/solvers/HologramSolver.h"
#include "plugin/extending/NamedFactories.h"
#include "plugin/extending/SolverRegistry.h"

#include <osgMidair/FieldSolver>

#include <utility>

namespace osgMidair
{

namespace
{

NamedFactories<FieldSolverFactory>& registry()
{
    static NamedFactories<FieldSolverFactory> all("solver");
    return all;
}

} // namespace

FieldSolverFactory SolverRegistry::find(const std::string& name)
{
    return registry().find(name);
}

std::vector<std::string> SolverRegistry::names()
{
    return registry().names();
}

bool registerSolver(const std::string& name, FieldSolverFactory make, std::string& error)
{
    return registry().add(name, std::move(make), midair::haptics::solverNames(), error);
}

} // namespace osgMidair
