// import midair: the C interface as a Python module.
#include "engine-bridge/python/Bindings.h"

namespace midair::python
{

namespace
{

/// midair.Error; never released, because errors may be raised while Python ends.
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
    // The text may be cut within a character.
    const auto words = py::reinterpret_steal<py::object>(
        PyUnicode_DecodeUTF8(text.data(), static_cast<py::ssize_t>(text.size()), "replace"));
    const py::object error = py::reinterpret_borrow<py::object>(errorType())(words);
    error.attr("status") = midair_status_name(status);
    PyErr_SetObject(errorType(), error.ptr());
    throw py::error_already_set();
}

void raise(midair_status status)
{
    raise(status, midair_last_error());
}

void requireEach(const py::array& numbers, const char* name, std::size_t count, const char* each)
{
    const bool isOne = numbers.ndim() == 0 && count == 1;
    if (isOne || (numbers.ndim() == 1 && static_cast<std::size_t>(numbers.size()) == count)) return;
    throw py::value_error(std::string(name) + " has to have one number for each " + each +
                          ", the shape (" + std::to_string(count) + ",), not " + shapeOf(numbers));
}

std::string shapeOf(const py::array& array)
{
    return py::str(array.attr("shape"));
}

std::int64_t
integerOf(const py::object& number, const char* name, std::int64_t least, std::int64_t most)
{
    const auto whole = py::reinterpret_steal<py::object>(PyNumber_Index(number.ptr()));
    if (!whole) throw py::error_already_set();
    int overflow = 0;
    const long long value = PyLong_AsLongLongAndOverflow(whole.ptr(), &overflow);
    if (overflow != 0 || value < least || value > most)
        raise(MIDAIR_INVALID,
              std::string(name) + " is " + py::str(whole).cast<std::string>() + "; it must be " +
                  std::to_string(least) + " .. " + std::to_string(most));
    return value;
}

std::size_t indexOf(const py::object& index)
{
    return static_cast<std::size_t>(integerOf(index, "index", 0, 1 << 30));
}

std::string pathOf(const py::object& path)
{
    PyObject* bytes = nullptr;
    if (PyUnicode_FSConverter(path.ptr(), &bytes) == 0) throw py::error_already_set();
    return py::reinterpret_steal<py::bytes>(bytes);
}

std::size_t rowsOf(const Doubles& places, const char* name, py::ssize_t columns)
{
    const bool isOne = places.ndim() == 1 && places.shape(0) == columns;
    const bool isMany = places.ndim() == 2 && places.shape(1) == columns;
    if (!isOne && !isMany)
        throw py::value_error(std::string(name) + " has to have the shape (n, " +
                              std::to_string(columns) + "), not " + shapeOf(places));
    return isOne ? 1 : static_cast<std::size_t>(places.shape(0));
}

} // namespace midair::python

PYBIND11_MODULE(midair, module)
{
    using namespace midair::python;
    py::options options;
    options.disable_function_signatures(); // Signatures.h makes Python's signatures.
    module.doc() =
        "Mid-air haptics: arrays of ultrasound transducers, fields that are felt, devices that "
        "play them.\n\nPlaces are in metres and in the array's frame, pressures peak pascals, "
        "times seconds. (n, 3) is an array of n places; one place may be (3,). Whatever fails "
        "raises midair.Error, a wrong shape ValueError, a wrong type TypeError.";
    PyObject* const error = PyErr_NewExceptionWithDoc(
        "midair.Error",
        "What a call of midair fails with. status: \"invalid\" (a value), \"closed\", \"unknown\" "
        "(a name or an index), \"refused\", \"not yet\", \"stopped\" (cancelled), \"silenced\" (a "
        "value that concerns safety), \"failed\" (a solver of yours raised, or the library did), "
        "\"silent\" (of solve(raise_if_silent=True)).",
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
    define(
        module,
        "settings",
        [] { return settings(false); },
        "Returns name and summary of each setting of a scene, a list of pairs of str. The summary "
        "has unit, values and default.");
    define(
        module,
        "properties",
        [] { return settings(true); },
        "Returns name and summary of each property of an object, a list of pairs of str.");
    // Threads of scenes call Python, which must not happen after its end; arrays fall silent.
    py::module_::import("atexit").attr("register")(py::cpp_function(
        []
        {
            closeScenes();
            awaitAbandoned();
            endCallbacks();
        }));
}
