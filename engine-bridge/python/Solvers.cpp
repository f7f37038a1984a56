// midair.Solver.
#include "engine-bridge/python/Bindings.h"

#include <complex>

namespace midair::python
{

namespace
{

/// midair.Solver
struct PySolver
{
    std::shared_ptr<OwnedSolver> owned;
    std::size_t transducers = 0;
};

PySolver openSolver(const OwnedScene& scene, const OwnedArray& array)
{
    PySolver solver;
    midair_solver* handle = nullptr;
    checked([&] { return midair_solver_open(scene.get(), &handle); });
    solver.owned = std::make_shared<OwnedSolver>(handle);
    checked([&] { return midair_array_size(array.get(), &solver.transducers); });
    return solver;
}

py::array_t<std::complex<float>>
solvePoints(const PySolver& solver, const Doubles& positions, const Doubles& targets, bool inPascal)
{
    const std::size_t count = rowsOf(positions, "positions");
    if (static_cast<std::size_t>(targets.size()) != count)
        throw py::value_error("targets has to have one number for each point");
    py::array_t<std::complex<float>> q(static_cast<py::ssize_t>(solver.transducers));
    auto* const to = reinterpret_cast<float*>(q.mutable_data());
    const double* const from = positions.data();
    const double* const wanted = targets.data();
    checked(
        [&]
        {
            return midair_solver_solve(
                solver.owned->get(), from, wanted, count, inPascal ? 1 : 0, to, solver.transducers);
        });
    return q;
}

} // namespace

void addSolvers(py::module_& module)
{
    py::class_<PySolver>(module, "Solver", "Solves points after points, without caps.")
        .def(py::init(&openSolver), py::arg("scene"), py::arg("array"))
        .def("solve",
             &solvePoints,
             py::arg("positions"),
             py::arg("targets"),
             py::arg("pascal") = false,
             "Activations, complex64, for points (n, 3) and their targets (n).")
        .def("figure",
             [](const PySolver& solver, const std::string& name)
             {
                 double value = 0.0;
                 checked(
                     [&]
                     { return midair_solver_figure(solver.owned->get(), name.c_str(), &value); });
                 return value;
             })
        .def("close", [](PySolver& solver) { solver.owned->close(); });
}

} // namespace midair::python
