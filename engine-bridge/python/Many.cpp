// midair.Scene.solve_many()
#include "engine-bridge/python/Bindings.h"

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <pybind11/stl.h>

namespace midair::python
{

namespace
{

/// Input and results of a call, which may continue after its caller was interrupted.
struct ManySolved
{
    std::vector<double> positions, targets;
    std::vector<std::uint8_t> phases;
    std::vector<midair_many_figures> figures;
    midair_many_layout layout{};
    midair_many many{};

    midair_status solve(midair_scene* scene)
    {
        return midair_solve_many(scene,
                                 &many,
                                 phases.data(),
                                 phases.size(),
                                 &layout,
                                 figures.empty() ? nullptr : figures.data());
    }
};

/// Returns an array of \a shape on a vector of \a all, which it keeps.
template<typename T>
py::array_t<T> arrayOn(const std::shared_ptr<ManySolved>& all,
                       const std::vector<T>& numbers,
                       std::vector<py::ssize_t> shape)
{
    const py::capsule owner(new std::shared_ptr<ManySolved>(all),
                            [](void* kept)
                            { delete static_cast<std::shared_ptr<ManySolved>*>(kept); });
    return py::array_t<T>(std::move(shape), numbers.data(), owner);
}

void setTargets(const Doubles& targets, ManySolved& all)
{
    const auto fields = static_cast<py::ssize_t>(all.many.fields),
               points = static_cast<py::ssize_t>(all.many.points);
    const bool isSame = targets.ndim() == 1 && targets.shape(0) == points;
    const bool isEach =
        targets.ndim() == 2 && targets.shape(0) == fields && targets.shape(1) == points;
    if (!isSame && !isEach)
        throw py::value_error("targets has to have the shape (" + std::to_string(points) +
                              ",) or (" + std::to_string(fields) + ", " + std::to_string(points) +
                              "), not " + shapeOf(targets));
    all.targets.assign(targets.data(), targets.data() + targets.size());
    all.many.targets = all.targets.data();
    all.many.same_targets = isSame ? 1 : 0;
}

py::tuple solveMany(const PyScene& scene,
                    const Doubles& positions,
                    const std::optional<Doubles>& targets,
                    const py::object& path,
                    double tolerance,
                    double phaseStep_rad,
                    const py::object& seed,
                    bool withFigures)
{
    if (positions.ndim() != 3 || positions.shape(2) != 3)
        throw py::value_error("positions has to have the shape (k, n, 3), not " +
                              shapeOf(positions));
    constexpr std::int64_t kMost = std::int64_t{1} << 53;
    const auto all = std::make_shared<ManySolved>();
    all->positions.assign(positions.data(), positions.data() + positions.size());
    all->many.struct_size = sizeof(midair_many);
    all->many.fields = static_cast<std::size_t>(positions.shape(0));
    all->many.points = static_cast<std::size_t>(positions.shape(1));
    all->many.positions = all->positions.data();
    if (targets) setTargets(*targets, *all);
    all->many.fields_in_path = static_cast<std::size_t>(integerOf(path, "path", 0, kMost));
    all->many.tolerance = tolerance;
    all->many.largest_phase_step_rad = phaseStep_rad;
    all->many.seed = static_cast<std::uint64_t>(integerOf(seed, "seed", 0, kMost));
    midair_scene* const handle = scene.get();
    midair_status queried = MIDAIR_OK; // the room; that refuses some arguments, too
    {
        const py::gil_scoped_release released;
        queried = all->solve(handle);
    }
    if (queried < 0) raise(queried);
    const auto transducers = static_cast<std::size_t>(all->layout.transducers);
    all->phases.resize(all->many.fields * transducers);
    if (withFigures) all->figures.resize(all->many.fields);
    const Outcome outcome = interruptible([all, handle] { return all->solve(handle); },
                                          [handle] { midair_cancel(handle); });
    if (outcome.status < 0) raise(outcome.status, outcome.why);
    const auto fields = static_cast<py::ssize_t>(all->many.fields);
    return py::make_tuple(
        arrayOn(all, all->phases, {fields, static_cast<py::ssize_t>(transducers)}),
        all->layout.phase_levels,
        withFigures ? py::object(arrayOn(all, all->figures, {fields})) : py::none());
}

} // namespace

void addMany(SceneClass& scene)
{
    PYBIND11_NUMPY_DTYPE(midair_many_figures, rms, level_Pa, loudness, phase_step_rad);
    scene.def(
        "solve_many",
        &solveMany,
        py::arg("positions"),
        py::arg("targets") = py::none(),
        py::arg("path") = 0,
        py::arg("tolerance") = 0.01,
        py::arg("phase_step") = 0.0,
        py::arg("seed") = 1,
        py::arg("figures") = false,
        "Solves k fields of n points, thousands a second, and plays none. positions: (k, n, 3), m; "
        "targets: ratios of the pressures, 0 and up, (n,) or (k, n), None: all equal. path: number "
        "of successive fields of which each starts from the one before; paths run on the scene's "
        "\"threads\"; 0: all fields, 1: no field depends on another. tolerance: the rms error that "
        "is good enough, 3e-4 .. 0.3. phase_step: largest change of a phase "
        "from field to field of a path, rad, 0: no bound. Returns phases, uint8, (k, m), level L "
        "means 2 pi L/P at full amplitude; P, an int; and, if figures, an array (k,) of rms, "
        "level_Pa, loudness and phase_step_rad, else None. Caps aren't applied: a scene with one "
        "is refused. Ctrl-C and cancel() abort it.");
}

} // namespace midair::python
