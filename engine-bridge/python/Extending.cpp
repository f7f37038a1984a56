// midair.register_solver(), register_device() and register_hands(): solvers, arrays and trackers
// that are written in Python.
#include "engine-bridge/python/Bindings.h"

#include <algorithm>
#include <atomic>
#include <complex>
#include <cstdio>
#include <sstream>
#include <type_traits>
#include <vector>

#include <pybind11/stl.h>

namespace midair::python
{

namespace
{

/// True once Python ends: nothing of it can be called any more.
std::atomic<bool>& hasEnded()
{
    static std::atomic<bool> ended{false};
    return ended;
}

void write(const char* what, char* error, std::size_t size)
{
    if (error && size > 0) std::snprintf(error, size, "%s", what);
}

/// Calls Python with its lock. Returns false, with what it raised in \a error, if it failed, or if
/// \a call says so.
template<typename Call>
bool calledPython(const Call& call, char* error = nullptr, std::size_t size = 0)
{
    if (hasEnded())
    {
        write("Python has ended", error, size);
        return false;
    }
    const py::gil_scoped_acquire lock;
    try
    {
        if constexpr (std::is_void_v<decltype(call())>)
        {
            call();
            return true;
        }
        else
            return call();
    }
    catch (py::error_already_set& raised)
    {
        write(raised.what(), error, size);
    }
    catch (const std::exception& thrown)
    {
        write(thrown.what(), error, size);
    }
    return false;
}

/// What a solver is asked for, as Python sees it. Its arrays are copies, which it may keep.
struct PyProblem
{
    py::array_t<double> positions;
    py::array_t<double> targets;
    py::array_t<std::complex<float>> matrix;
    bool pascal = false;
    bool phaseOnly = true;
    double loudness = 1.0;
    double deadline_ms = 0.0;
    int maxIterations = 0;
    const midair_problem* problem = nullptr; ///< null once the call is over
};

std::shared_ptr<PyProblem> problemOf(const midair_problem& given)
{
    const auto n = static_cast<py::ssize_t>(given.points);
    const auto m = static_cast<py::ssize_t>(given.transducers);
    auto problem = std::make_shared<PyProblem>();
    problem->positions = py::array_t<double>({n, py::ssize_t(3)}, given.positions);
    problem->targets = py::array_t<double>(n, given.targets);
    problem->matrix = py::array_t<std::complex<float>>(
        {n, m}, reinterpret_cast<const std::complex<float>*>(given.matrix));
    problem->pascal = given.in_pascal != 0;
    problem->phaseOnly = given.phase_only != 0;
    problem->loudness = given.loudness;
    problem->deadline_ms = given.deadline_ms;
    problem->maxIterations = given.max_iterations;
    problem->problem = &given;
    return problem;
}

std::int32_t
solve(void* user, const midair_problem* given, float* activations, char* error, std::size_t size)
{
    const auto call = [&]
    {
        const std::shared_ptr<PyProblem> problem = problemOf(*given);
        const py::object result = static_cast<py::object*>(user)->operator()(problem);
        problem->problem = nullptr;
        const auto q = result.cast<
            py::array_t<std::complex<float>, py::array::c_style | py::array::forcecast>>();
        if (q.size() != static_cast<py::ssize_t>(given->transducers))
            throw py::value_error("the solver returned " + std::to_string(q.size()) +
                                  " activations for " + std::to_string(given->transducers) +
                                  " transducers");
        std::copy_n(q.data(), q.size(), reinterpret_cast<std::complex<float>*>(activations));
    };
    return calledPython(call, error, size) ? 0 : 1;
}

/// An open device that is written in Python.
struct PyDevice
{
    py::object object;
    py::ssize_t transducers = 0;
};

py::dict optionsOf(const char* lines)
{
    py::dict options;
    std::istringstream all(lines);
    for (std::string line; std::getline(all, line);)
        if (const std::size_t at = line.find('='); at != std::string::npos)
            options[py::str(line.substr(0, at))] = line.substr(at + 1);
    return options;
}

void* openDevice(void* user,
                 const char* path,
                 const char* options,
                 const std::int32_t* boards,
                 std::uint32_t transducers,
                 char* error,
                 std::size_t size)
{
    PyDevice* opened = nullptr;
    const auto call = [&]
    {
        const auto m = static_cast<py::ssize_t>(transducers);
        const py::array_t<std::int32_t> board(m, boards);
        py::object object =
            static_cast<py::object*>(user)->operator()(path, optionsOf(options), board);
        if (object.is_none()) throw py::value_error("the device could not be opened");
        opened = new PyDevice{std::move(object), m};
    };
    calledPython(call, error, size);
    return opened;
}

std::int32_t playDevice(void* instance, const std::uint8_t* phases, const std::uint8_t* amplitudes)
{
    auto& device = *static_cast<PyDevice*>(instance);
    const auto call = [&]
    {
        const py::object taken =
            device.object.attr("play")(py::array_t<std::uint8_t>(device.transducers, phases),
                                       py::array_t<std::uint8_t>(device.transducers, amplitudes));
        return taken.is_none() || taken.cast<bool>();
    };
    return calledPython(call) ? 0 : 1;
}

std::int32_t silenceDevice(void* instance)
{
    const auto call = [&] { static_cast<PyDevice*>(instance)->object.attr("silence")(); };
    return calledPython(call) ? 0 : 1;
}

std::int32_t isReadyDevice(void* instance)
{
    auto& device = *static_cast<PyDevice*>(instance);
    const auto call = [&]
    {
        return !py::hasattr(device.object, "is_ready") ||
               device.object.attr("is_ready")().cast<bool>();
    };
    return calledPython(call) ? 1 : 0;
}

void closeDevice(void* instance)
{
    auto* const device = static_cast<PyDevice*>(instance);
    const auto call = [&]
    {
        if (py::hasattr(device->object, "close")) device->object.attr("close")();
    };
    calledPython(call);
    if (hasEnded()) return; // the object can't be let go without Python
    const py::gil_scoped_acquire lock;
    delete device;
}

void* openHands(void* user, const char* options, char* error, std::size_t size)
{
    py::object* opened = nullptr;
    const auto call = [&]
    {
        py::object object = static_cast<py::object*>(user)->operator()(options);
        if (object.is_none()) throw py::value_error("there is no such hand source");
        opened = new py::object(std::move(object));
    };
    calledPython(call, error, size);
    return opened;
}

std::int32_t handsNow(void* instance, double time_s, midair_hand* hands, std::size_t capacity)
{
    std::int32_t count = -1;
    const auto call = [&]
    {
        const py::object result = static_cast<py::object*>(instance)->attr("hands")(time_s);
        if (result.is_none()) return;
        const auto all = result.cast<py::array_t<midair_hand, py::array::c_style>>();
        if (static_cast<std::size_t>(all.size()) > capacity) return;
        std::copy_n(all.data(), all.size(), hands);
        count = static_cast<std::int32_t>(all.size());
    };
    calledPython(call);
    return count;
}

void closeHands(void* instance)
{
    if (hasEnded()) return;
    const py::gil_scoped_acquire lock;
    delete static_cast<py::object*>(instance);
}

/// What is registered is called for as long as the program runs.
void* keptForever(const py::object& callable)
{
    if (!PyCallable_Check(callable.ptr()))
        throw py::type_error("what is registered is no function");
    return new py::object(callable);
}

void registerDevice(const std::string& scheme,
                    const py::object& open,
                    unsigned int phaseLevels,
                    const std::vector<float>& amplitudes,
                    double fieldsPerSecond)
{
    midair_driver driver{};
    driver.struct_size = sizeof driver;
    driver.user = keptForever(open);
    driver.open = openDevice;
    driver.play = playDevice;
    driver.silence = silenceDevice;
    driver.is_ready = isReadyDevice;
    driver.close = closeDevice;
    driver.phase_levels = phaseLevels;
    driver.amplitudes = amplitudes.data();
    driver.amplitude_count = static_cast<std::uint32_t>(amplitudes.size());
    driver.fields_per_second = fieldsPerSecond;
    checked(midair_register_device, scheme.c_str(), &driver);
}

void registerHands(const std::string& name, const py::object& open)
{
    midair_hand_source source{};
    source.struct_size = sizeof source;
    source.user = keptForever(open);
    source.open = openHands;
    source.hands = handsNow;
    source.close = closeHands;
    checked(midair_register_hands, name.c_str(), &source);
}

} // namespace

void endCallbacks()
{
    hasEnded() = true;
}

void addExtending(py::module_& module)
{
    py::class_<PyProblem, std::shared_ptr<PyProblem>>(
        module, "Problem", "What a solver is asked for.")
        .def_readonly("positions", &PyProblem::positions, "(n, 3), m")
        .def_readonly("targets", &PyProblem::targets, "(n), Pa if pascal, else ratios")
        .def_readonly("matrix", &PyProblem::matrix, "(n, m), complex64, Pa at full drive")
        .def_readonly("pascal", &PyProblem::pascal)
        .def_readonly("phase_only", &PyProblem::phaseOnly)
        .def_readonly("loudness", &PyProblem::loudness)
        .def_readonly("deadline_ms", &PyProblem::deadline_ms)
        .def_readonly("max_iterations", &PyProblem::maxIterations)
        .def_property_readonly(
            "stopped",
            [](const PyProblem& problem)
            { return !problem.problem || problem.problem->is_stopped(problem.problem) != 0; },
            "True when nobody waits for the field any more.");
    module.def(
        "register_solver",
        [](const std::string& name, const py::object& function)
        {
            void* const user = keptForever(function);
            checked(midair_register_solver, name.c_str(), solve, user);
        },
        py::arg("name"),
        py::arg("function"),
        "function(problem) returns m activations; scene[\"solver\"] = name uses it.");
    module.def("register_device",
               &registerDevice,
               py::arg("scheme"),
               py::arg("open"),
               py::arg("phase_levels") = 256,
               py::arg("amplitudes") = std::vector<float>(),
               py::arg("fields_per_second") = 0.0,
               "open(path, options, boards) returns an object with play(phases, amplitudes), "
               "silence() and, if it likes, is_ready() and close().");
    module.def("register_hands",
               &registerHands,
               py::arg("name"),
               py::arg("open"),
               "open(options) returns an object with hands(time), which returns an array of "
               "hand_dtype or None.");
}

} // namespace midair::python
