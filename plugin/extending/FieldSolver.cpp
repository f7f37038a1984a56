#include "engine-bridge/extending/OwnSolver.h"

#include <osgMidair/FieldSolver>

#include <memory>
#include <utility>

namespace osgMidair
{

bool registerSolver(const std::string& name, FieldSolverFactory make, std::string& error)
{
    midair::bridge::FieldMethodFactory adapted;
    if (make)
        adapted = [make = std::move(make)]() -> std::shared_ptr<FieldMethod>
        {
            osg::ref_ptr<FieldSolver> solver = make();
            FieldMethod* const called = solver.get();
            if (!called) return nullptr;
            return {called, [solver](FieldMethod*) mutable { solver = nullptr; }};
        };
    return midair::bridge::registerMethod(name, std::move(adapted), error);
}

} // namespace osgMidair
