// import midair: the C interface as a Python module.
#include "engine-bridge/python/Bindings.h"

namespace midair::python
{

namespace
{

/// midair.Error; never let go, as raising may go on while Python ends.
PyObject*& errorType()
{
    static PyObject* type = nullptr;
    return type;
}

py::list settings(bool ofObjects)
{
    py::list all;
    const char* name = nullptr;
    const char* summary = nullptr;
    for (std::size_t i = 0; midair_setting(ofObjects ? 1 : 0, i, &name, &summary) == MIDAIR_OK; ++i)
        all.append(py::make_tuple(name, summary));
    return all;
}

} // namespace

void raise(midair_status status, const std::string& text)
{
    const py::object error = py::reinterpret_borrow<py::object>(errorType())(text);
    error.attr("status") = midair_status_name(status);
    PyErr_SetObject(errorType(), error.ptr());
    throw py::error_already_set();
}

void raise(midair_status status)
{
    raise(status, midair_last_error());
}

std::size_t rowsOf(const Doubles& places, const char* name, py::ssize_t columns)
{
    const bool isOne = places.ndim() == 1 && places.shape(0) == columns;
    const bool isMany = places.ndim() == 2 && places.shape(1) == columns;
    if (!isOne && !isMany)
        throw py::value_error(std::string(name) + " has to have the shape (n, " +
                              std::to_string(columns) + ")");
    return isOne ? 1 : static_cast<std::size_t>(places.shape(0));
}

} // namespace midair::python

PYBIND11_MODULE(midair, module)
{
    using namespace midair::python;
    module.doc() =
        "Mid-air haptics: arrays of ultrasound transducers, fields that are felt, devices "
        "that play them. Metres, pascals (peak), seconds; the array's frame.";
    PyObject* const error = PyErr_NewExceptionWithDoc(
        "midair.Error",
        "What a call of midair fails with; status: \"invalid\", \"refused\" and so on.",
        PyExc_RuntimeError,
        nullptr);
    if (!error) throw py::error_already_set();
    errorType() = error;
    module.add_object("Error", error);
    const std::uint32_t version = midair_version();
    module.attr("__version__") = std::to_string(version / 10000) + "." +
                                 std::to_string(version / 100 % 100) + "." +
                                 std::to_string(version % 100);
    addArrays(module);
    addFields(module);
    addScenes(module);
    addSolvers(module);
    addExtending(module);
    module.def(
        "settings", [] { return settings(false); }, "Name and summary of each setting of a scene.");
    module.def(
        "properties",
        [] { return settings(true); },
        "Name and summary of each property of an object.");
    // Threads of scenes call Python, which they can't once it ends; arrays fall silent.
    py::module_::import("atexit").attr("register")(py::cpp_function(
        []
        {
            closeScenes();
            endCallbacks();
        }));
}
