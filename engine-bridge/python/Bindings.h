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

/// Numbers for the C interface: a C-contiguous array of doubles is used directly, anything else is
/// converted into one.
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Raises midair.Error, with the status and the last error of this thread.
[[noreturn]] void raise(midair_status status);
[[noreturn]] void raise(midair_status status, const std::string& text);

/// Calls a function of the C interface without the GIL, because it may wait for a callback that
/// needs it.
template<typename Function, typename... Arguments>
midair_status unlocked(Function* function, const Arguments&... arguments)
{
    const py::gil_scoped_release released;
    return function(arguments...);
}

/// The same; raises on failure. Returns MIDAIR_OK or MIDAIR_SILENT.
template<typename Function, typename... Arguments>
midair_status checked(Function* function, const Arguments&... arguments)
{
    const midair_status status = unlocked(function, arguments...);
    if (status < 0) raise(status);
    return status;
}

/// Result of a call of the C interface, with the thread's last error.
struct Outcome
{
    midair_status status = MIDAIR_OK;
    std::string why;
};

/// Runs \a call, a solve, without the GIL. On Python's main thread it checks every 20 ms for Ctrl-C
/// and other signal handlers that raise: then it aborts the solve by \a cancel and raises. \a call
/// runs on another thread then and may continue afterwards, so it owns its data.
Outcome interruptible(const std::function<midair_status()>& call,
                      const std::function<void()>& cancel);

/// Returns the text of \a of written by \a read(of.., room, size, needed); if it grows meanwhile,
/// it is read again.
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

/// Owns a handle of the C interface and closes it.
template<typename Handle, midair_status (*Close)(Handle*)>
class Owned
{
public:
    explicit Owned(Handle* handle) : _handle(handle) {}
    ~Owned() { close(); } // NOLINT(bugprone-exception-escape): the C interface throws nothing
    Owned(const Owned&) = delete;
    Owned& operator=(const Owned&) = delete;

    Handle* get() const { return _handle; }
    /// Closing a scene waits for its thread, which may wait for the GIL.
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

    const std::string name; ///< as given
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

/// midair.Field. The memory of views stays valid until the last view is gone, even if the field is
/// closed.
struct PyField
{
    std::shared_ptr<OwnedField> owned; ///< null: closed
    bool isSilent = false;
    std::string why; ///< why it is silent

    midair_field* get() const { return owned ? owned->get() : nullptr; }
};

/// Loads an array by its name or path.
std::shared_ptr<PyArray> loadArray(const py::object& name);
/// Wraps the field of a call with \a status, which is not below 0.
PyField fieldOf(midair_field* field, midair_status status, const std::string& why);

/// Fails unless \a places has rows of \a columns numbers; returns the number of rows.
std::size_t rowsOf(const Doubles& places, const char* name, py::ssize_t columns = 3);
/// Fails unless \a numbers has the shape (\a count), or is a scalar where \a count is 1. \a each:
/// "point", the item of one number.
void requireEach(const py::array& numbers, const char* name, std::size_t count, const char* each);
/// Fails unless the position is (3,) and the orientation (4,). \a name: of the position.
void requirePose(const Doubles& place, const char* name, const Doubles& orientation);
/// Does the same for a head, which is returned.
midair_head headOf(const Doubles& position, const Doubles& orientation, double age_s);
/// "(3, 4)"
std::string shapeOf(const py::array& array);
/// Returns a whole number; fails for other values and outside \a least .. \a most.
std::int64_t
integerOf(const py::object& number, const char* name, std::int64_t least, std::int64_t most);
/// Returns the index of a field in turn.
std::size_t indexOf(const py::object& index);
/// Returns the path in a str, bytes or os.PathLike.
std::string pathOf(const py::object& path);
/// Returns an array of T; fails for other element types. \a records: "hand_dtype".
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
void addMany(SceneClass& scene);
void addSolvers(py::module_& module);
void addExtending(py::module_& module);
/// \}

/// Closes all open scenes; to be called when Python ends.
void closeScenes();
/// Waits for aborted solves, so that none calls Python after its end.
void awaitAbandoned();
/// Stops all callbacks into Python.
void endCallbacks();
/// Raises KeyboardInterrupt in Python solvers that continue although their solve is cancelled.
void interruptCancelled();

} // namespace midair::python
