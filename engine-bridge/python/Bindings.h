#pragma once

#include "engine-bridge/c/midair.h"
#include "engine-bridge/python/Signatures.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

namespace midair::python
{

/// Numbers as the C interface takes them; an array of doubles, row by row, is
/// taken as it is, and anything else is converted into one.
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Raises midair.Error, with the status and the last error of this thread.
[[noreturn]] void raise(midair_status status);
[[noreturn]] void raise(midair_status status, const std::string& text);

/// Calls a function of the C interface without Python's lock, since it may wait
/// for a callback that needs that.
template<typename Function, typename... Arguments>
midair_status unlocked(Function* function, const Arguments&... arguments)
{
    const py::gil_scoped_release released;
    return function(arguments...);
}

/// The same, and raises what it fails with. Returns MIDAIR_OK or MIDAIR_SILENT.
template<typename Function, typename... Arguments>
midair_status checked(Function* function, const Arguments&... arguments)
{
    const midair_status status = unlocked(function, arguments...);
    if (status < 0) raise(status);
    return status;
}

/// What a call of the C interface came to, with the thread's last error.
struct Outcome
{
    midair_status status = MIDAIR_OK;
    std::string why;
};

/// Runs \a call, of a solve, without Python's lock. On Python's main thread a
/// Ctrl-C, or what else raises in a signal's handler, is looked for every 20
/// ms: it breaks off the solve by \a cancel and is raised here. \a call runs on
/// another thread then, and may go on after that: it owns what it uses.
Outcome interruptible(const std::function<midair_status()>& call,
                      const std::function<void()>& cancel);

/// Returns the text of \a of that \a read(of.., room, size, needed) writes; one
/// that grows meanwhile is read again.
template<typename Function, typename... Arguments>
std::string textFrom(Function* read, const Arguments&... of)
{
    std::string text(256, '\0');
    std::size_t needed = 0;
    midair_status status = unlocked(read, of..., text.data(), text.size(), &needed);
    for (; status == MIDAIR_TOO_SMALL;
         status = unlocked(read, of..., text.data(), text.size(), &needed))
        text.resize(needed);
    if (status < 0) raise(status);
    text.resize(needed - 1);
    return text;
}

/// Owns a handle of the C interface, and closes it.
template<typename Handle, midair_status (*Close)(Handle*)>
class Owned
{
public:
    explicit Owned(Handle* handle) : _handle(handle) {}
    ~Owned() { close(); } // NOLINT(bugprone-exception-escape): the C interface throws nothing
    Owned(const Owned&) = delete;
    Owned& operator=(const Owned&) = delete;

    Handle* get() const { return _handle; }
    /// Closing a scene waits for its thread, which may wait for Python.
    void close()
    {
        Handle* const handle = _handle;
        _handle = nullptr;
        if (!handle) return;
        const py::gil_scoped_release released;
        Close(handle);
    }

private:
    Handle* _handle;
};

using OwnedArray = Owned<midair_array, midair_array_close>;
using OwnedScene = Owned<midair_scene, midair_scene_close>;

/// midair.Array
struct PyArray : OwnedArray
{
    PyArray(midair_array* array, std::string itsName) : OwnedArray(array), name(std::move(itsName))
    {
    }

    const std::string name; ///< as it was asked for
};

/// midair.Scene
struct PyScene : OwnedScene
{
    PyScene(midair_scene* scene, std::string itsArray) :
        OwnedScene(scene),
        array(std::move(itsArray))
    {
    }

    const std::string array; ///< its name
};
using SceneClass = Class<PyScene, std::shared_ptr<PyScene>>;

using OwnedField = Owned<midair_field, midair_field_close>;
using OwnedSolver = Owned<midair_solver, midair_solver_close>;

/// midair.Field. What views show stays until the last of them is gone, closed
/// or not.
struct PyField
{
    std::shared_ptr<OwnedField> owned; ///< null: closed
    bool isSilent = false;
    std::string why; ///< it is silent

    midair_field* get() const { return owned ? owned->get() : nullptr; }
};

/// Loads an array by its name or path.
std::shared_ptr<PyArray> loadArray(const py::object& name);
/// The field of a call that came to \a status, which isn't below 0.
PyField fieldOf(midair_field* field, midair_status status, const std::string& why);

/// Fails unless \a places has rows of \a columns numbers; returns their number.
std::size_t rowsOf(const Doubles& places, const char* name, py::ssize_t columns = 3);
/// Fails unless \a numbers has the shape (\a count), or is one number where \a
/// count is 1. \a each: "point", what there is one for.
void requireEach(const py::array& numbers, const char* name, std::size_t count, const char* each);
/// Fails for a place that isn't (3,), or a turn that isn't (4,). \a name: of the place.
void requirePose(const Doubles& place, const char* name, const Doubles& orientation);
/// The same of a head, which is returned.
midair_head headOf(const Doubles& position, const Doubles& orientation, double age_s);
/// "(3, 4)"
std::string shapeOf(const py::array& array);
/// Returns a whole number; fails for what is none, and out of \a least .. \a
/// most.
std::int64_t
integerOf(const py::object& number, const char* name, std::int64_t least, std::int64_t most);
/// Returns the number of a field in turn.
std::size_t indexOf(const py::object& index);
/// Returns the path that a str, bytes or os.PathLike stands for.
std::string pathOf(const py::object& path);
/// Returns an array of T; fails for an array of anything else. \a records:
/// "hand_dtype".
template<typename T>
py::array_t<T, py::array::c_style>
recordsOf(const py::object& given, const char* name, const char* records)
{
    if (!py::array_t<T>::check_(given))
    {
        const std::string what =
            py::isinstance<py::array>(given)
                ? "an array of " + py::str(given.attr("dtype")).cast<std::string>()
                : std::string(Py_TYPE(given.ptr())->tp_name);
        throw py::type_error(std::string(name) + " has to be an array of midair." + records +
                             ", not " + what);
    }
    return py::array_t<T, py::array::c_style>::ensure(given);
}

/// \{ Each adds its classes to the module.
void addArrays(py::module_& module);
void addFields(py::module_& module);
void addScenes(py::module_& module);
void addMessages(py::module_& module, SceneClass& scene);
void addSolvers(py::module_& module);
void addExtending(py::module_& module);
/// \}

/// Closes all scenes that are open, to be called when Python ends.
void closeScenes();
/// Waits for solves that were broken off, so that none calls Python when it
/// ends.
void awaitAbandoned();
/// From now on no callback of the library calls Python.
void endCallbacks();
/// Raises KeyboardInterrupt in solvers in Python that run on although their
/// solve is cancelled.
void interruptCancelled();

} // namespace midair::python
