#include "engine-bridge/extending/OwnSolver.h"

#include <osgMidair/FieldSolver>

#include <memory>
#include <utility>

namespace osgMidair
{

namespace
{

/// An application's solver as the libraries call it.
class SolverOfApplication : public midair::bridge::FieldMethod
{
public:
    explicit SolverOfApplication(const osg::ref_ptr<FieldSolver>& solver) : _solver(solver) {}

    bool solve(const Problem& given, std::complex<float>* activations, std::string& error) override
    {
        FieldSolver::Problem problem;
        problem.points = given.points;
        problem.transducers = given.transducers;
        problem.positions = given.positions;
        problem.targets = given.targets;
        problem.isAbsolute = given.isAbsolute;
        problem.matrix = given.matrix;
        problem.loudness = given.loudness;
        problem.phaseOnly = given.phaseOnly;
        problem.maxIterations = given.maxIterations;
        problem.deadline_ms = given.deadline_ms;
        problem.isStopped = given.isStopped;
        return _solver->solve(problem, activations, error);
    }

private:
    const osg::ref_ptr<FieldSolver> _solver;
};

} // namespace

bool registerSolver(const std::string& name, FieldSolverFactory make, std::string& error)
{
    midair::bridge::FieldMethodFactory adapted;
    if (make)
        adapted = [make = std::move(make)]() -> std::shared_ptr<midair::bridge::FieldMethod>
        {
            osg::ref_ptr<FieldSolver> solver = make();
            return solver ? std::make_shared<SolverOfApplication>(solver) : nullptr;
        };
    return midair::bridge::registerMethod(name, std::move(adapted), error);
}

} // namespace osgMidair
