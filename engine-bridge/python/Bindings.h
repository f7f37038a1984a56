#pragma once

#include "engine-bridge/c/midair.h"

#include <cstddef>
#include <memory>
#include <string>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

namespace midair::python
{

namespace py = pybind11;

/// Numbers as the C interface takes them; an array of doubles, row by row, is taken as it is, and
/// anything else is converted into one.
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Raises midair.Error, with the status and the last error of this thread.
[[noreturn]] void raise(midair_status status);
[[noreturn]] void raise(midair_status status, const std::string& text);

/// Calls a function of the C interface without Python's lock, since it may wait for a callback that
/// needs that.
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

/// Returns the text of \a of that \a read(of.., room, size, needed) writes; one that grows
/// meanwhile is read again.
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
using OwnedField = Owned<midair_field, midair_field_close>;
using OwnedSolver = Owned<midair_solver, midair_solver_close>;

/// midair.Field. What views show stays until the last of them is gone, closed or not.
struct PyField
{
    std::shared_ptr<OwnedField> owned; ///< null: closed
    bool isSilent = false;
    std::string why; ///< it is silent

    midair_field* get() const { return owned ? owned->get() : nullptr; }
};

/// Fails unless \a places has rows of \a columns numbers; returns their number.
std::size_t rowsOf(const Doubles& places, const char* name, py::ssize_t columns = 3);

/// \{ Each adds its classes to the module.
void addArrays(py::module_& module);
void addFields(py::module_& module);
void addScenes(py::module_& module);
void addMessages(py::module_& module, py::class_<OwnedScene, std::shared_ptr<OwnedScene>>& scene);
void addSolvers(py::module_& module);
void addExtending(py::module_& module);
/// \}

/// Closes all scenes that are open, to be called when Python ends.
void closeScenes();
/// From now on no callback of the library calls Python.
void endCallbacks();

} // namespace midair::python
