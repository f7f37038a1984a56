// midair.register_solver(), register_device() and register_hands(): solvers, arrays and trackers
// written in Python.
#include "engine-bridge/python/Bindings.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <complex>
#include <cstdio>
#include <list>
#include <sstream>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include <pybind11/stl.h>

namespace midair::python
{

namespace
{

using Activations = py::array_t<std::complex<float>, py::array::c_style | py::array::forcecast>;

/// True once Python ends: nothing in it may be called any more.
std::atomic<bool>& hasEnded()
{
    static std::atomic<bool> ended{false};
    return ended;
}

void write(const char* what, char* error, std::size_t size)
{
    if (error && size > 0) std::snprintf(error, size, "%s", what);
}

/// "ZeroDivisionError: division by zero (/home/me/own.py:12)"
std::string inWords(const py::error_already_set& raised)
{
    std::string words = raised.type().attr("__name__").cast<std::string>() + ": " +
                        py::str(raised.value()).cast<std::string>();
    if (!raised.trace()) return words;
    const py::object frames = py::module_::import("traceback").attr("extract_tb")(raised.trace());
    if (py::len(frames) == 0) return words;
    const py::object last = frames[py::int_(-1)];
    return words + " (" + py::str(last.attr("filename")).cast<std::string>() + ":" +
           py::str(last.attr("lineno")).cast<std::string>() + ")";
}

/// Calls Python with the GIL. Returns false, with the exception in \a error, if it raised, or if \a
/// call returns false.
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
        write(inWords(raised).c_str(), error, size);
    }
    catch (const std::exception& thrown)
    {
        write(thrown.what(), error, size);
    }
    return false;
}

/// Calls Python, and throws its exception.
template<typename Call>
bool calledOrThrown(const Call& call)
{
    std::array<char, 1024> error{};
    const bool isDone = calledPython(call, error.data(), error.size());
    if (error.front()) throw std::runtime_error(error.data());
    return isDone;
}

bool isTrue(const py::object& object)
{
    const int truth = PyObject_IsTrue(object.ptr());
    if (truth < 0) throw py::error_already_set();
    return truth != 0;
}

/// Input of a Python solver. Its arrays are copies, which the solver may keep.
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

/// A running Python solver and its Python thread; guarded by the GIL.
struct Running
{
    const midair_problem* problem = nullptr;
    unsigned long thread = 0;
    bool isInterrupted = false;
};

std::list<Running>& running()
{
    static auto* const all = new std::list<Running>;
    return *all;
}

/// Registers a solver while it runs; afterwards its problem reports that it has stopped.
class WhileRunning
{
public:
    explicit WhileRunning(PyProblem& problem) :
        _problem(problem),
        _at(running().insert(running().end(),
                             {problem.problem, PyThread_get_thread_ident(), false}))
    {
    }
    ~WhileRunning()
    {
        // An exception not raised in time must not hit the thread's next work.
        if (_at->isInterrupted) PyThreadState_SetAsyncExc(_at->thread, nullptr);
        running().erase(_at);
        _problem.problem = nullptr;
    }
    WhileRunning(const WhileRunning&) = delete;
    WhileRunning& operator=(const WhileRunning&) = delete;

private:
    PyProblem& _problem;
    const std::list<Running>::iterator _at;
};

/// Converts a solver's result to activations; raises for other types.
Activations activationsOf(const py::object& result, py::ssize_t transducers)
{
    const std::string wanted =
        "; it has to return the shape (" + std::to_string(transducers) + ",), complex";
    Activations q = Activations::ensure(result);
    if (!q || q.ndim() == 0)
        throw py::type_error(std::string("the solver returned a ") +
                             Py_TYPE(result.ptr())->tp_name + wanted);
    if (q.ndim() != 1 || q.size() != transducers)
        throw py::value_error("the solver returned an array of the shape " + shapeOf(q) + wanted);
    return q;
}

std::int32_t
solve(void* user, const midair_problem* given, float* activations, char* error, std::size_t size)
{
    const auto call = [&]
    {
        const std::shared_ptr<PyProblem> problem = problemOf(*given);
        const WhileRunning isRunning(*problem);
        const py::object result = static_cast<py::object*>(user)->operator()(problem);
        const Activations q = activationsOf(result, static_cast<py::ssize_t>(given->transducers));
        std::copy_n(q.data(), q.size(), reinterpret_cast<std::complex<float>*>(activations));
    };
    return calledPython(call, error, size) ? 0 : 1;
}

/// An open device written in Python.
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
        return taken.is_none() || isTrue(taken);
    };
    return calledOrThrown(call) ? 0 : 1;
}

std::int32_t silenceDevice(void* instance)
{
    const auto call = [&] { static_cast<PyDevice*>(instance)->object.attr("silence")(); };
    return calledOrThrown(call) ? 0 : 1;
}

std::int32_t isReadyDevice(void* instance)
{
    auto& device = *static_cast<PyDevice*>(instance);
    const auto call = [&]
    { return !py::hasattr(device.object, "is_ready") || isTrue(device.object.attr("is_ready")()); };
    return calledOrThrown(call) ? 1 : 0;
}

void closeDevice(void* instance)
{
    auto* const device = static_cast<PyDevice*>(instance);
    const auto call = [&]
    {
        if (py::hasattr(device->object, "close")) device->object.attr("close")();
    };
    calledPython(call);
    if (hasEnded()) return; // the object can't be released without Python
    const py::gil_scoped_acquire lock;
    delete device;
}

/// \a none: error for a callable that returns None.
void* openSource(void* user, const char* options, char* error, std::size_t size, const char* none)
{
    py::object* opened = nullptr;
    const auto call = [&]
    {
        py::object object = static_cast<py::object*>(user)->operator()(options);
        if (object.is_none()) throw py::value_error(none);
        opened = new py::object(std::move(object));
    };
    calledPython(call, error, size);
    return opened;
}

void closeSource(void* instance)
{
    if (hasEnded()) return;
    const py::gil_scoped_acquire lock;
    delete static_cast<py::object*>(instance);
}

void* openHands(void* user, const char* options, char* error, std::size_t size)
{
    return openSource(user, options, error, size, "there is no such hand source");
}

std::int32_t handsNow(void* instance, double time_s, midair_hand* hands, std::size_t capacity)
{
    std::int32_t count = -1;
    const auto call = [&]
    {
        const py::object result = static_cast<py::object*>(instance)->attr("hands")(time_s);
        if (result.is_none()) return;
        const auto all = recordsOf<midair_hand>(result, "what hands() returns", "hand_dtype");
        if (static_cast<std::size_t>(all.size()) > capacity)
            throw py::value_error("hands() returned " + std::to_string(all.size()) +
                                  " hands; there is room for " + std::to_string(capacity));
        std::copy_n(all.data(), all.size(), hands);
        count = static_cast<std::int32_t>(all.size());
    };
    calledOrThrown(call);
    return count;
}

void* openHead(void* user, const char* options, char* error, std::size_t size)
{
    return openSource(user, options, error, size, "there is no such head source");
}

std::int32_t headNow(void* instance, double time_s, midair_head* head)
{
    std::int32_t isTracked = 0;
    const auto call = [&]
    {
        const py::object result = static_cast<py::object*>(instance)->attr("head")(time_s);
        if (result.is_none()) return;
        const py::sequence both = py::cast<py::sequence>(result);
        if (both.size() != 2)
            throw py::value_error("head() has to return a position and an orientation, or None");
        *head = headOf(py::cast<Doubles>(both[0]), py::cast<Doubles>(both[1]), 0.0);
        isTracked = 1;
    };
    calledOrThrown(call);
    return isTracked;
}

/// Keeps a registered callable for the rest of the program.
void* keptForever(const py::object& callable, const char* name)
{
    if (!PyCallable_Check(callable.ptr()))
        throw py::type_error(std::string(name) + " has to be callable, not " +
                             Py_TYPE(callable.ptr())->tp_name);
    return new py::object(callable);
}

void registerDevice(const std::string& scheme,
                    const py::object& open,
                    const py::object& phaseLevels,
                    const std::vector<float>& amplitudes,
                    double fieldsPerSecond)
{
    midair_driver driver{};
    driver.struct_size = sizeof driver;
    driver.user = keptForever(open, "open");
    driver.open = openDevice;
    driver.play = playDevice;
    driver.silence = silenceDevice;
    driver.is_ready = isReadyDevice;
    driver.close = closeDevice;
    driver.phase_levels =
        static_cast<std::uint32_t>(integerOf(phaseLevels, "phase_levels", 0, 256));
    driver.amplitudes = amplitudes.data();
    driver.amplitude_count = static_cast<std::uint32_t>(amplitudes.size());
    driver.fields_per_second = fieldsPerSecond;
    checked(midair_register_device, scheme.c_str(), &driver);
}

void registerHands(const std::string& name, const py::object& open)
{
    midair_hand_source source{};
    source.struct_size = sizeof source;
    source.user = keptForever(open, "open");
    source.open = openHands;
    source.hands = handsNow;
    source.close = closeSource;
    checked(midair_register_hands, name.c_str(), &source);
}

void registerHead(const std::string& name, const py::object& open)
{
    midair_head_source source{};
    source.struct_size = sizeof source;
    source.user = keptForever(open, "open");
    source.open = openHead;
    source.head = headNow;
    source.close = closeSource;
    checked(midair_register_head, name.c_str(), &source);
}

std::string describeProblem(const PyProblem& problem)
{
    return "<midair.Problem: " + std::to_string(problem.targets.size()) + " points, " +
           std::to_string(problem.matrix.shape(1)) + " transducers, targets " +
           (problem.pascal ? "in Pa" : "relative") + ">";
}

void addProblem(py::module_& module)
{
    Class<PyProblem, std::shared_ptr<PyProblem>>(
        module,
        "Problem",
        "Input of a solver. n: points, m: transducers; its arrays are the solver's to "
        "keep.")
        .def_readonly("positions",
                      &PyProblem::positions,
                      "Places of the points, float64, shape (n, 3), m, in the array's frame.")
        .def_readonly("targets",
                      &PyProblem::targets,
                      "Peak pressures wanted, float64, shape (n,), Pa if pascal, else only ratios.")
        .def_readonly("matrix",
                      &PyProblem::matrix,
                      "Pressure of each transducer at full drive and phase 0 at each point, "
                      "complex64, shape (n, m), Pa: p = matrix @ q for activations q.")
        .def_readonly("pascal", &PyProblem::pascal, "True: targets are in Pa; False: ratios.")
        .def_readonly("phase_only", &PyProblem::phaseOnly, "True: all amplitudes are to be equal.")
        .def_readonly("loudness", &PyProblem::loudness, "As the scene asks for it, a float.")
        .def_readonly("deadline_ms", &PyProblem::deadline_ms, "Time limit, ms; 0: none.")
        .def_readonly("max_iterations",
                      &PyProblem::maxIterations,
                      "Most iterations, an int; 0: the solver's own limit.")
        .def_property_readonly(
            "stopped",
            [](const PyProblem& problem)
            { return !problem.problem || problem.problem->is_stopped(problem.problem) != 0; },
            "True when the field is no longer needed: return soon.")
        .def("__repr__", &describeProblem, "Returns sizes and what targets are in.");
}

} // namespace

void endCallbacks()
{
    hasEnded() = true;
}

void interruptCancelled()
{
    for (Running& one : running())
    {
        if (one.isInterrupted || one.problem->is_stopped(one.problem) == 0) continue;
        one.isInterrupted = true;
        PyThreadState_SetAsyncExc(one.thread, PyExc_KeyboardInterrupt);
    }
}

void addExtending(py::module_& module)
{
    addProblem(module);
    define(
        module,
        "register_solver",
        [](const std::string& name, const py::object& function)
        {
            void* const user = keptForever(function, "function");
            checked(midair_register_solver, name.c_str(), solve, user);
        },
        py::arg("name"),
        py::arg("function"),
        "Registers a solver: scene[\"solver\"] = name uses it. function(problem) takes a Problem "
        "and returns m activations, complex, shape (m,), |q| <= 1. What it raises fails the solve: "
        "Scene.solve() raises Error \"failed\". It may be called on any thread.");
    define(module,
           "register_device",
           &registerDevice,
           py::arg("scheme"),
           py::arg("open"),
           py::arg("phase_levels") = 256,
           py::arg("amplitudes") = std::vector<float>(),
           py::arg("fields_per_second") = 0.0,
           "Registers a device: scene.play(\"SCHEME:path?key=value\") plays on it. open(path, "
           "options, boards) takes a str, a dict of str and int32 (m,), and returns an object with "
           "play(phases, amplitudes), two arrays of uint8 (m,), silence() and, if it likes, "
           "is_ready() and close(). amplitudes: what the levels are, rising from 0 to 1; "
           "fields_per_second: Hz, the most that it takes, 0: any number.");
    define(module,
           "register_hands",
           &registerHands,
           py::arg("name"),
           py::arg("open"),
           "Registers a hand source: open_hands(\"NAME:options\") takes it. open(options) returns "
           "an object with hands(time), which takes s and returns an array of hand_dtype, in m, or "
           "None.");
    define(
        module,
        "register_head",
        &registerHead,
        py::arg("name"),
        py::arg("open"),
        "Registers a head source: open_head(\"NAME:options\") takes it. open(options) returns an "
        "object with head(time), which takes s and returns a position (3,) in m and an "
        "orientation (4,), as of set_head(), or None.");
}

} // namespace midair::python
