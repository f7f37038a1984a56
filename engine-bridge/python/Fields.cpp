// midair.Field, midair.Array and midair.Solver.
#include "engine-bridge/python/Bindings.h"

#include <complex>

namespace midair::python
{

namespace
{

using Complexes = py::array_t<std::complex<float>>;

midair_field_info infoOf(const PyField& field)
{
    midair_field_info info{};
    checked(midair_field_about, field.get(), &info);
    return info;
}

/// The field's own memory, which the view keeps.
py::array activations(const PyField& field, std::size_t index)
{
    const float* numbers = nullptr;
    checked(midair_field_view, field.get(), index, &numbers);
    auto* const keeps = new std::shared_ptr<OwnedField>(field.owned);
    const py::capsule owner(
        keeps, [](void* kept) { delete static_cast<std::shared_ptr<OwnedField>*>(kept); });
    py::array view(py::dtype::of<std::complex<float>>(),
                   {static_cast<py::ssize_t>(infoOf(field).transducers)},
                   {static_cast<py::ssize_t>(sizeof(std::complex<float>))},
                   numbers,
                   owner);
    view.attr("flags").attr("writeable") = false;
    return view;
}

py::tuple levels(const PyField& field, std::size_t index)
{
    const auto count = static_cast<py::ssize_t>(infoOf(field).transducers);
    py::array_t<std::int32_t> phases(count);
    py::array_t<std::int32_t> amplitudes(count);
    checked(midair_field_levels,
            field.get(),
            index,
            phases.mutable_data(),
            amplitudes.mutable_data(),
            static_cast<std::size_t>(count));
    return py::make_tuple(phases, amplitudes);
}

py::array points(const PyField& field)
{
    const auto count = static_cast<py::ssize_t>(infoOf(field).points);
    py::array_t<midair_point> all(count);
    if (count > 0)
        checked(
            midair_field_points, field.get(), all.mutable_data(), static_cast<std::size_t>(count));
    return std::move(all);
}

py::dict figures(const PyField& field)
{
    py::dict all;
    const char* name = nullptr;
    double value = 0.0;
    infoOf(field); // raises for a closed one
    for (std::size_t i = 0;; ++i)
    {
        // The first one computes the exposure.
        const midair_status status =
            unlocked(midair_field_figure_at, field.get(), i, &name, &value);
        if (status == MIDAIR_UNKNOWN) return all;
        if (status < 0) raise(status);
        all[name] = value;
    }
}

Complexes pressures(const PyField& field, const Doubles& places, std::size_t index)
{
    const std::size_t count = rowsOf(places, "places");
    Complexes p(static_cast<py::ssize_t>(count));
    auto* const to = reinterpret_cast<float*>(p.mutable_data());
    checked(midair_field_pressures, field.get(), index, places.data(), count, to);
    return p;
}

py::array_t<float> felt(const PyField& field, const Doubles& places)
{
    const std::size_t count = rowsOf(places, "places");
    py::array_t<float> p(static_cast<py::ssize_t>(count));
    checked(midair_field_felt, field.get(), places.data(), count, p.mutable_data());
    return p;
}

std::string text(const PyField& field, const char* name)
{
    return textFrom(midair_field_text, field.get(), name);
}

std::shared_ptr<OwnedArray> loadArray(const std::string& name)
{
    midair_array* array = nullptr;
    checked(midair_array_load, name.c_str(), &array);
    return std::make_shared<OwnedArray>(array);
}

std::shared_ptr<OwnedArray> makeArray(const std::string& name,
                                      const py::array_t<midair_transducer, py::array::c_style>& all,
                                      double frequency_Hz,
                                      double source_Pa_m)
{
    midair_array* array = nullptr;
    const auto count = static_cast<std::size_t>(all.size());
    checked(midair_array_make, name.c_str(), all.data(), count, frequency_Hz, source_Pa_m, &array);
    return std::make_shared<OwnedArray>(array);
}

std::size_t sizeOf(const OwnedArray& array)
{
    std::size_t size = 0;
    checked(midair_array_size, array.get(), &size);
    return size;
}

py::array transducers(const OwnedArray& array)
{
    const std::size_t size = sizeOf(array);
    py::array_t<midair_transducer> all(static_cast<py::ssize_t>(size));
    checked(midair_array_transducers, array.get(), all.mutable_data(), size);
    return std::move(all);
}

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
    checked(midair_solver_open, scene.get(), &handle);
    solver.owned = std::make_shared<OwnedSolver>(handle);
    checked(midair_array_size, array.get(), &solver.transducers);
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
    checked(midair_solver_solve,
            solver.owned->get(),
            positions.data(),
            targets.data(),
            count,
            inPascal ? 1 : 0,
            to,
            solver.transducers);
    return q;
}

} // namespace

void addArrays(py::module_& module)
{
    PYBIND11_NUMPY_DTYPE(midair_transducer, position, normal, phase_offset_rad, gain, board, dead);
    module.attr("transducer_dtype") = py::dtype::of<midair_transducer>();
    py::class_<OwnedArray, std::shared_ptr<OwnedArray>>(module, "Array", "Transducers; immutable.")
        .def(py::init(&loadArray),
             py::arg("name"),
             "Loads \"octagon\", \"board\", the name of a shipped array, or a JSON file.")
        .def_static(
            "from_json",
            [](const std::string& json)
            {
                midair_array* array = nullptr;
                checked(midair_array_from_json, json.c_str(), &array);
                return std::make_shared<OwnedArray>(array);
            },
            py::arg("json"),
            "Reads the text of such a file.")
        .def_static("make",
                    &makeArray,
                    py::arg("name"),
                    py::arg("transducers"),
                    py::arg("frequency") = 40e3,
                    py::arg("source") = 10.1,
                    "Makes one of transducers, a numpy array of transducer_dtype; frequency in Hz, "
                    "source: Pa m.")
        .def_property_readonly("transducers",
                               &transducers,
                               "All transducers, a numpy array of transducer_dtype; a copy.")
        .def("close", &OwnedArray::close)
        .def("__len__", &sizeOf);
}

void addFields(py::module_& module)
{
    PYBIND11_NUMPY_DTYPE(
        midair_point, position, normal, wanted_Pa, achieved_Pa, object, field, reserved);
    py::class_<PyField>(module, "Field", "What was solved or is played; immutable.")
        .def("activations",
             &activations,
             py::arg("index") = 0,
             "Activations of field index in turn, complex64, one for each transducer; a view that "
             "can't be written and keeps the field's memory.")
        .def(
            "levels",
            &levels,
            py::arg("index") = 0,
            "Phases and amplitudes in the array's levels, two arrays of int32: the last columns of "
            "midair-solve's drive.csv.")
        .def("pressures",
             &pressures,
             py::arg("places"),
             py::arg("index") = 0,
             "Complex peak pressure of field index at places (n, 3), complex64.")
        .def("felt",
             &felt,
             py::arg("places"),
             "Root of the mean of |p|^2 over all fields at places (n, 3), float32.")
        .def(
            "write_drive",
            [](const PyField& field, const std::string& file, std::size_t index)
            { checked(midair_field_write_drive, field.get(), index, file.c_str()); },
            py::arg("file"),
            py::arg("index") = 0,
            "Writes field index as midair-solve's drive.csv.")
        .def_property_readonly("points", &points, "The control points, a structured array; a copy.")
        .def_property_readonly("figures", &figures, "All figures by name, a dict.")
        .def_property_readonly("fields", [](const PyField& field) { return infoOf(field).fields; })
        .def_property_readonly("transducers",
                               [](const PyField& field) { return infoOf(field).transducers; })
        .def_property_readonly("rate", [](const PyField& field) { return infoOf(field).rate_Hz; })
        .def_property_readonly("frame", [](const PyField& field) { return infoOf(field).frame; })
        .def_property_readonly("latency_ms",
                               [](const PyField& field) { return infoOf(field).latency_ms; })
        .def_property_readonly("playing",
                               [](const PyField& field) { return infoOf(field).playing != 0; })
        .def_property_readonly("solver", [](const PyField& field) { return text(field, "solver"); })
        .def_property_readonly("stop", [](const PyField& field) { return text(field, "stop"); })
        .def_property_readonly("message",
                               [](const PyField& field) { return text(field, "message"); })
        .def_readonly("silent", &PyField::isSilent, "True: nothing sounds; why says why.")
        .def_readonly("why", &PyField::why)
        .def("close", [](PyField& field) { field.owned.reset(); });
}

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
                 checked(midair_solver_figure, solver.owned->get(), name.c_str(), &value);
                 return value;
             })
        .def("close", [](PySolver& solver) { solver.owned->close(); });
}

} // namespace midair::python
