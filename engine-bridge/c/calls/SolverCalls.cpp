// midair_solver_..(): one set of points after another, without caps.
#include "engine-bridge/c/inside/Field.h"
#include "engine-bridge/c/inside/Scene.h"
#include "engine-bridge/extending/OwnSolver.h"
#include "haptics/base/Limits.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/sequence/FieldSettings.h"

#include <algorithm>

#include <fmt/format.h>
#include <pthread.h>

using namespace midair;
using namespace midair::capi;

namespace midair::capi
{

namespace
{

/// The object behind a midair_solver.
struct OpenSolver
{
    base::MadeHere isOurs; ///< otherwise its threads are the parent's
    std::shared_ptr<const ArrayPair> array;
    haptics::Medium medium;
    int maxPoints = 0; ///< 0: no limit of its own
    base::StopSource stop;
    std::unique_ptr<haptics::HologramSolver> solver MIDAIR_PT_GUARDED_BY(mutex);

    base::Mutex mutex;                                      ///< held by a solve
    haptics::ControlPoints points MIDAIR_GUARDED_BY(mutex); ///< kept to reuse its memory
    Eigen::VectorXcf q MIDAIR_GUARDED_BY(mutex);
    haptics::SolveReport report MIDAIR_GUARDED_BY(mutex);
    bool isSolved MIDAIR_GUARDED_BY(mutex) = false;
};

Handles<midair_solver, OpenSolver>& solvers()
{
    static auto* const all = new Handles<midair_solver, OpenSolver>("midair_solver");
    return *all;
}

void lockSolvers()
{
    solvers().lock();
}

void unlockSolvers()
{
    solvers().unlock();
}

const int kSolversWatchForks = ::pthread_atfork(lockSolvers, unlockSolvers, unlockSolvers);

std::shared_ptr<OpenSolver> solverOf(midair_solver* handle)
{
    if (CallbackScope::isInside())
        fail(MIDAIR_INVALID, "a callback may not call a function with a scene or a solver");
    static_cast<void>(kSolversWatchForks);
    std::shared_ptr<OpenSolver> solver = solvers().find(handle);
    if (!solver->isOurs) fail(MIDAIR_CLOSED, std::string("the midair_solver is ") + base::kForked);
    return solver;
}

void setPoints(const double* positions,
               const double* targets,
               std::size_t count,
               bool inPascal,
               haptics::ControlPoints& points)
{
    if (count < 1 || count > static_cast<std::size_t>(base::kMostControlPoints))
        fail(MIDAIR_INVALID,
             fmt::format("count is {}; it must be 1 .. {}", count, base::kMostControlPoints));
    requireFinite(&given(positions, "positions"), 3 * count, "positions", 3);
    given(targets, "targets");
    for (std::size_t i = 0; i < count; ++i)
        if (!(targets[i] >= 0.0 && targets[i] <= base::kMostPressure_Pa))
            fail(MIDAIR_INVALID,
                 fmt::format("target {} is {:g}; it must be 0 .. {:g}",
                             i,
                             targets[i],
                             base::kMostPressure_Pa));
    const auto n = static_cast<Eigen::Index>(count);
    points.positions = Eigen::Map<const Eigen::Matrix3Xd>(positions, 3, n);
    points.normals.setZero(3, n);
    points.targets = Eigen::Map<const Eigen::VectorXd>(targets, n);
    points.absolute = inPascal;
}

} // namespace

} // namespace midair::capi

midair_status midair_solver_open(midair_scene* scene, midair_solver** solver)
{
    return called(
        [&]
        {
            const auto of = sceneOf(scene);
            given(solver, "solver");
            SceneSettings settings;
            auto made = std::make_shared<OpenSolver>();
            {
                const base::Lock lock(of->mutex);
                const std::string why = of->whySilenced();
                if (!why.empty()) fail(MIDAIR_SILENCED, why);
                settings = of->settings;
                made->array = of->markedArray();
            }
            refuseUnused(settings,
                         "a midair_solver solves for one set of points and",
                         [](const auto& row) { return (row.use & base::Use::POINTS) != 0; });
            made->medium = haptics::mediumOf(settings);
            haptics::SolverOptions options;
            base::assignPart<haptics::SolverSettings>(options, settings);
            options.updateRate_Hz = settings.fieldRate;
            options.skipTolerance = settings.motionTolerance;
            options.stop = made->stop.token();
            made->maxPoints = settings.maxPoints;
            made->solver = bridge::makeAnySolver(
                settings.solver.empty() ? haptics::solverNames().front() : settings.solver,
                options);
            *solver = solvers().add(std::move(made));
        });
}

midair_status midair_solver_solve(midair_solver* solver,
                                  const double* positions,
                                  const double* targets,
                                  size_t count,
                                  int32_t in_pascal,
                                  float* activations,
                                  size_t transducers)
{
    return called(
        [&]
        {
            const auto of = solverOf(solver);
            given(activations, "activations");
            const haptics::TransducerArray& array = of->array->solvable;
            if (transducers != static_cast<std::size_t>(array.size()))
                fail(transducers < static_cast<std::size_t>(array.size()) ? MIDAIR_TOO_SMALL
                                                                          : MIDAIR_INVALID,
                     fmt::format("transducers is {}; the array has {}", transducers, array.size()));
            const base::Lock lock(of->mutex);
            if (of->maxPoints > 0 && count > static_cast<std::size_t>(of->maxPoints))
                fail(MIDAIR_INVALID,
                     fmt::format("count is {}; maxPoints is {}", count, of->maxPoints));
            setPoints(positions, targets, count, in_pascal != 0, of->points);
            of->isSolved = false;
            of->stop.clear();
            of->report = of->solver->solve(of->points, array, of->medium, of->q);
            if (of->report.stop == haptics::StopReason::STOPPED) throw base::Stopped();
            requireSolved(of->report);
            of->isSolved = true;
            std::copy_n(
                of->q.data(), of->q.size(), reinterpret_cast<std::complex<float>*>(activations));
            if (of->q.isZero(0.0F)) return silentFor(of->report.message);
            return static_cast<midair_status>(MIDAIR_OK);
        });
}

midair_status midair_solver_cancel(midair_solver* solver)
{
    return called([&] { solverOf(solver)->stop.request(); });
}

midair_status midair_solver_figure(midair_solver* solver, const char* name, double* value)
{
    return called(
        [&]
        {
            const auto of = solverOf(solver);
            const std::string wanted = textGiven(name, "name", 256);
            given(value, "value");
            const base::Lock lock(of->mutex);
            if (!of->isSolved) fail(MIDAIR_NOT_YET, "the solver has solved nothing so far");
            if (!findFigure(haptics::figuresOf(of->report), wanted, *value))
                fail(MIDAIR_UNKNOWN, "there is no figure \"" + wanted + "\"");
        });
}

midair_status midair_solver_close(midair_solver* solver)
{
    return called(
        [&]
        {
            if (!CallbackScope::isInside() && !solvers().find(solver)->isOurs)
            {
                Handles<midair_solver, OpenSolver>::leave(solvers().take(solver));
                return;
            }
            solverOf(solver);
            solvers().take(solver);
        });
}
