// midair.Field, midair.Array and midair.Solver.
#include "engine-bridge/python/Bindings.h"

#include <cmath>
#include <complex>
#include <sstream>
#include <vector>

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

/// Returns a view of the field's own memory, which it keeps alive.
py::array activations(const PyField& field, const py::object& index)
{
    const float* numbers = nullptr;
    checked(midair_field_view, field.get(), indexOf(index), &numbers);
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

py::tuple levels(const PyField& field, const py::object& index)
{
    const auto count = static_cast<py::ssize_t>(infoOf(field).transducers);
    py::array_t<std::int32_t> phases(count);
    py::array_t<std::int32_t> amplitudes(count);
    checked(midair_field_levels,
            field.get(),
            indexOf(index),
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
    infoOf(field); // raises if closed
    for (std::size_t i = 0;; ++i)
    {
        // The first figure computes the exposure.
        const midair_status status =
            unlocked(midair_field_figure_at, field.get(), i, &name, &value);
        if (status == MIDAIR_UNKNOWN) return all;
        if (status < 0) raise(status);
        all[name] = value;
    }
}

Complexes pressures(const PyField& field, const Doubles& places, const py::object& index)
{
    const std::size_t count = rowsOf(places, "places");
    Complexes p(static_cast<py::ssize_t>(count));
    auto* const to = reinterpret_cast<float*>(p.mutable_data());
    checked(midair_field_pressures, field.get(), indexOf(index), places.data(), count, to);
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

py::bytes bytesOf(const PyField& field)
{
    std::size_t needed = 0;
    checked(midair_field_bytes, field.get(), static_cast<void*>(nullptr), std::size_t(0), &needed);
    std::string bytes(needed, '\0');
    checked(midair_field_bytes,
            field.get(),
            static_cast<void*>(bytes.data()),
            bytes.size(),
            static_cast<std::size_t*>(nullptr));
    return {bytes};
}

PyField fieldFrom(const py::bytes& bytes)
{
    midair_field* field = nullptr;
    const std::string all = bytes;
    const midair_status status =
        checked(midair_field_from_bytes, static_cast<const void*>(all.data()), all.size(), &field);
    return fieldOf(field, status, midair_last_error());
}

std::string describe(const PyField& field)
{
    if (!field.owned) return "<midair.Field, closed>";
    const midair_field_info info = infoOf(field);
    std::ostringstream out;
    out << "<midair.Field: " << info.points << " points, " << info.transducers << " transducers, "
        << info.fields << (info.fields == 1 ? " field" : " fields");
    double level_Pa = 0.0;
    checked(midair_field_figure, field.get(), "level_Pa", &level_Pa);
    if (field.isSilent)
        out << ", silent: " << field.why;
    else
        out << ", " << std::lround(level_Pa) << " Pa, " << text(field, "solver") << " "
            << text(field, "stop");
    return out.str() + ">";
}

std::shared_ptr<PyArray> readArray(const std::string& json)
{
    midair_array* array = nullptr;
    checked(midair_array_from_json, json.c_str(), &array);
    const py::object all = py::module_::import("json").attr("loads")(json);
    return std::make_shared<PyArray>(array,
                                     py::str(all.attr("get")("name", "")).cast<std::string>());
}

std::shared_ptr<PyArray> makeArray(const std::string& name,
                                   const py::object& transducers,
                                   double frequency_Hz,
                                   double source_Pa_m)
{
    midair_array* array = nullptr;
    const auto all = recordsOf<midair_transducer>(transducers, "transducers", "transducer_dtype");
    if (all.ndim() != 1)
        throw py::value_error("transducers has to have the shape (n,), not " + shapeOf(all));
    const auto count = static_cast<std::size_t>(all.size());
    checked(midair_array_make, name.c_str(), all.data(), count, frequency_Hz, source_Pa_m, &array);
    return std::make_shared<PyArray>(array, name);
}

std::size_t sizeOf(const PyArray& array)
{
    std::size_t size = 0;
    checked(midair_array_size, array.get(), &size);
    return size;
}

py::array transducers(const PyArray& array)
{
    const std::size_t size = sizeOf(array);
    py::array_t<midair_transducer> all(static_cast<py::ssize_t>(size));
    checked(midair_array_transducers, array.get(), all.mutable_data(), size);
    return std::move(all);
}

std::string describeArray(const PyArray& array)
{
    if (!array.get()) return "<midair.Array, closed>";
    return "<midair.Array \"" + array.name + "\", " + std::to_string(sizeOf(array)) +
           " transducers>";
}

/// midair.Solver
struct PySolver
{
    std::shared_ptr<OwnedSolver> owned;
    std::size_t transducers = 0;
};

PySolver openSolver(const PyScene& scene, const PyArray& array)
{
    PySolver solver;
    midair_solver* handle = nullptr;
    checked(midair_solver_open, scene.get(), &handle);
    solver.owned = std::make_shared<OwnedSolver>(handle);
    checked(midair_array_size, array.get(), &solver.transducers);
    return solver;
}

Complexes
solvePoints(const PySolver& solver, const Doubles& positions, const Doubles& targets, bool inPascal)
{
    const std::size_t count = rowsOf(positions, "positions");
    requireEach(targets, "targets", count, "point");
    struct Numbers
    {
        std::vector<double> positions;
        std::vector<double> targets;
        std::vector<float> q;
    };
    const auto numbers = std::make_shared<Numbers>();
    numbers->positions.assign(positions.data(), positions.data() + positions.size());
    numbers->targets.assign(targets.data(), targets.data() + targets.size());
    numbers->q.resize(2 * solver.transducers);
    midair_solver* const handle = solver.owned->get();
    const Outcome outcome = interruptible(
        [=, transducers = solver.transducers]
        {
            return midair_solver_solve(handle,
                                       numbers->positions.data(),
                                       numbers->targets.data(),
                                       count,
                                       inPascal ? 1 : 0,
                                       numbers->q.data(),
                                       transducers);
        },
        [handle] { midair_solver_cancel(handle); });
    if (outcome.status < 0) raise(outcome.status, outcome.why);
    return Complexes(static_cast<py::ssize_t>(solver.transducers),
                     reinterpret_cast<const std::complex<float>*>(numbers->q.data()));
}

double figureOf(const PySolver& solver, const std::string& name)
{
    double value = 0.0;
    checked(midair_solver_figure, solver.owned->get(), name.c_str(), &value);
    return value;
}

std::string describeSolver(const PySolver& solver)
{
    if (!solver.owned->get()) return "<midair.Solver, closed>";
    return "<midair.Solver for " + std::to_string(solver.transducers) + " transducers>";
}

using FieldClass = Class<PyField>;

void addPressures(FieldClass& field)
{
    field
        .def("activations",
             &activations,
             py::arg("index") = 0,
             "Returns the activations of field index in turn, complex64, shape (m,), 1 is full "
             "drive; a view that can't be written and keeps the field's memory.")
        .def("levels",
             &levels,
             py::arg("index") = 0,
             "Returns phases and amplitudes of field index in the array's levels, two arrays of "
             "int32, shape (m,): the last columns of midair-solve's drive.csv.")
        .def("pressures",
             &pressures,
             py::arg("places"),
             py::arg("index") = 0,
             "Returns the complex peak pressure of field index in Pa at places (n, 3) in m, "
             "complex64, shape (n,).")
        .def("felt",
             &felt,
             py::arg("places"),
             "Returns the root of the mean of |p|^2 over all fields in Pa at places (n, 3) in m, "
             "float32, shape (n,).")
        .def(
            "write_drive",
            [](const PyField& field, const py::object& file, const py::object& index)
            {
                const std::string path = pathOf(file);
                checked(midair_field_write_drive, field.get(), indexOf(index), path.c_str());
            },
            py::arg("file"),
            py::arg("index") = 0,
            "Writes field index as midair-solve's drive.csv; file: str or os.PathLike.")
        .def("to_bytes",
             &bytesOf,
             "Returns the field serialized as bytes, from which from_bytes() makes an equal one; "
             "so does "
             "pickle.")
        .def_static("from_bytes",
                    &fieldFrom,
                    py::arg("data"),
                    "Returns the Field whose to_bytes(), of the same version, made data.");
}

void addFigures(FieldClass& field)
{
    field
        .def_property_readonly(
            "points",
            &points,
            "The control points, a structured array, shape (n,), a copy: position and normal (3,) "
            "in m, wanted_Pa, achieved_Pa, object, field.")
        .def_property_readonly("figures",
                               &figures,
                               "All figures by name, a dict of float, as in midair-solve's "
                               "summary.json; units are in the names.")
        .def_property_readonly(
            "fields",
            [](const PyField& field) { return infoOf(field).fields; },
            "k, the number of fields that are played in turn, an int; 1: one is held.")
        .def_property_readonly(
            "transducers",
            [](const PyField& field) { return infoOf(field).transducers; },
            "m, the number of transducers, an int.")
        .def_property_readonly(
            "rate",
            [](const PyField& field) { return infoOf(field).rate_Hz; },
            "Rate at which fields in turn follow each other, Hz; 0: one is held.")
        .def_property_readonly(
            "frame",
            [](const PyField& field) { return infoOf(field).frame; },
            "Number of the update() that it is for, an int; 0: of solve().")
        .def_property_readonly(
            "latency_ms",
            [](const PyField& field) { return infoOf(field).latency_ms; },
            "From update() to the device, ms; 0: of solve().")
        .def_property_readonly(
            "playing",
            [](const PyField& field) { return infoOf(field).playing != 0; },
            "True: a device is open, has taken it, and it is not silence.");
}

void addWords(FieldClass& field)
{
    field
        .def_property_readonly(
            "solver",
            [](const PyField& field) { return text(field, "solver"); },
            "Name of the solver, a str.")
        .def_property_readonly(
            "stop",
            [](const PyField& field) { return text(field, "stop"); },
            "Why the solver ended, a str: \"converged\", \"deadline\" and so on.")
        .def_property_readonly(
            "message",
            [](const PyField& field) { return text(field, "message"); },
            "A message about it for people, a str; empty: none.")
        .def_property_readonly(
            "feeling",
            [](const PyField& field) { return text(field, "feeling"); },
            "What most people feel where it is strongest, with figures[\"fingertipForce_N\"] on a "
            "fingertip, a str: \"too weak to feel\", \"faint\", \"clear\" or \"strong\".")
        .def_readonly("silent", &PyField::isSilent, "True: nothing sounds; why says why.")
        .def_readonly("why", &PyField::why, "Why it is silent, a str; empty: it isn't.")
        .def(
            "close",
            [](PyField& field) { field.owned.reset(); },
            "Frees the field; views of its activations stay valid.")
        .def(py::pickle(&bytesOf, &fieldFrom))
        .def("__repr__", &describe, "Returns sizes, level and solver, or why it is silent.");
}

} // namespace

std::shared_ptr<PyArray> loadArray(const py::object& name)
{
    midair_array* array = nullptr;
    const std::string path = pathOf(name);
    checked(midair_array_load, path.c_str(), &array);
    return std::make_shared<PyArray>(array, path);
}

PyField fieldOf(midair_field* field, midair_status status, const std::string& why)
{
    PyField made;
    made.owned = std::make_shared<OwnedField>(field);
    made.isSilent = status == MIDAIR_SILENT;
    if (made.isSilent) made.why = why;
    return made;
}

void addArrays(py::module_& module)
{
    PYBIND11_NUMPY_DTYPE(midair_transducer, position, normal, phase_offset_rad, gain, board, dead);
    module.attr("transducer_dtype") = py::dtype::of<midair_transducer>();
    Class<PyArray, std::shared_ptr<PyArray>>(
        module,
        "Array",
        "Array(name)\n--\n\nTransducers; immutable. Its frame is right-handed, in metres; the "
        "origin of \"octagon\" is the centre of its workspace, inside the prism; that of \"board\" "
        "the middle of its own plane z = 0, from which it emits towards +z: (0, 0, 0.15) is over "
        "it.")
        .def(py::init(&loadArray),
             py::arg("name"),
             "Loads \"octagon\", \"board\", the name of a shipped array, or a JSON file (str or "
             "os.PathLike).")
        .def_static("from_json",
                    &readArray,
                    py::arg("json"),
                    "Returns the Array that the text of such a file describes.")
        .def_static(
            "make",
            &makeArray,
            py::arg("name"),
            py::arg("transducers"),
            py::arg("frequency") = 40e3,
            py::arg("source") = 10.1,
            "Returns an Array of transducers, an array of transducer_dtype, shape (m,). frequency: "
            "Hz; source: peak pressure times distance on the axis at full drive, Pa m.")
        .def_property_readonly("transducers",
                               &transducers,
                               "All transducers, an array of transducer_dtype, shape (m,); a copy. "
                               "Positions in m, normals of length 1.")
        .def_property_readonly(
            "name",
            [](const PyArray& array) { return array.name; },
            "The name or path that it was made with, a str.")
        .def("close", &PyArray::close, "Frees the array; scenes that use it keep it.")
        .def("__len__", &sizeOf, "Returns the number of transducers.")
        .def("__repr__", &describeArray, "Returns name and number of transducers.");
}

void addFields(py::module_& module)
{
    PYBIND11_NUMPY_DTYPE(
        midair_point, position, normal, wanted_Pa, achieved_Pa, object, field, reserved);
    FieldClass field(module,
                     "Field",
                     "A solved or played field; immutable, can be pickled. m: transducers, n: "
                     "control points, k: fields in turn.");
    addPressures(field);
    addFigures(field);
    addWords(field);
}

void addSolvers(py::module_& module)
{
    Class<PySolver>(module,
                    "Solver",
                    "Solver(scene, array)\n--\n\nSolves one set of points after the other, each "
                    "from the last field, without caps.")
        .def(py::init(&openSolver),
             py::arg("scene"),
             py::arg("array"),
             "Takes the settings that the Scene has now; array: the scene's.")
        .def("solve",
             &solvePoints,
             py::arg("positions"),
             py::arg("targets"),
             py::arg("pascal") = false,
             "Returns activations, complex64, shape (m,), for points (n, 3) in m and their targets "
             "(n,), in Pa if pascal, else relative to each other. Ctrl-C aborts it.")
        .def("figure",
             &figureOf,
             py::arg("name"),
             "Returns a figure of the last solve by its name, a float: \"rms\", \"level_Pa\".")
        .def(
            "close",
            [](PySolver& solver) { solver.owned->close(); },
            "Frees the solver, after waiting for a running solve.")
        .def("__repr__", &describeSolver, "Returns the number of transducers.");
}

} // namespace midair::python
