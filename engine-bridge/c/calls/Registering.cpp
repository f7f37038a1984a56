// midair_register_device() and midair_register_solver().
#include "engine-bridge/c/inside/Calls.h"
#include "engine-bridge/extending/ArrayDriver.h"
#include "engine-bridge/extending/OwnSolver.h"

#include <array>
#include <map>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>

using namespace midair;
using namespace midair::capi;

namespace
{

constexpr std::size_t kErrorBytes = 1024;

/// Returns a callback's text, whose terminator may be missing.
std::string textOf(const std::array<char, kErrorBytes>& text)
{
    return {text.data(), strnlen(text.data(), text.size())};
}

/// A driver of the application. It copies the levels, because the application's array may be freed.
class DriverOfCallbacks : public bridge::ArrayDriver
{
public:
    DriverOfCallbacks(const midair_driver& driver, std::vector<float> amplitudes) :
        _driver(driver),
        _amplitudes(std::move(amplitudes))
    {
    }
    ~DriverOfCallbacks() override
    {
        const CallbackScope inside;
        try
        {
            if (_instance && _driver.close) _driver.close(_instance);
        }
        catch (...) // NOLINT(bugprone-empty-catch): it is gone, and there is nobody to tell
        {
        }
    }
    DriverOfCallbacks(const DriverOfCallbacks&) = delete;
    DriverOfCallbacks& operator=(const DriverOfCallbacks&) = delete;

    bool open(const std::string& path,
              const std::map<std::string, std::string>& options,
              const Layout& layout,
              std::string& error) override
    {
        std::string lines;
        for (const auto& [key, value] : options)
            lines.append(key).append("=").append(value).append("\n");
        std::vector<int32_t> boards(layout.board.begin(), layout.board.end());
        boards.resize(layout.transducers, 0);
        std::array<char, kErrorBytes> text{};
        const CallbackScope inside;
        _instance = _driver.open(_driver.user,
                                 path.c_str(),
                                 lines.c_str(),
                                 boards.data(),
                                 layout.transducers,
                                 text.data(),
                                 text.size() - 1);
        if (!_instance) error = textOf(text);
        return _instance != nullptr;
    }
    bool play(const unsigned char* phases, const unsigned char* amplitudes) override
    {
        const CallbackScope inside;
        return _driver.play(_instance, phases, amplitudes) == 0;
    }
    void silence() override
    {
        const CallbackScope inside;
        const int32_t code = _driver.silence(_instance);
        if (code != 0) throw std::runtime_error(fmt::format("code {}", code));
    }
    bool isReady() const override
    {
        const CallbackScope inside;
        return !_driver.is_ready || _driver.is_ready(_instance) != 0;
    }
    std::string getStatus() const override
    {
        if (!_driver.status) return {};
        std::array<char, kErrorBytes> text{};
        const CallbackScope inside;
        _driver.status(_instance, text.data(), text.size() - 1);
        return textOf(text);
    }
    unsigned int getPhaseLevels() const override
    {
        return _driver.phase_levels == 0 ? 256 : _driver.phase_levels;
    }
    std::vector<float> getAmplitudes() const override { return _amplitudes; }
    double getFieldsPerSecond() const override { return _driver.fields_per_second; }

private:
    const midair_driver _driver;
    const std::vector<float> _amplitudes;
    void* _instance = nullptr;
};

int32_t isStopped(const midair_problem* problem)
{
    const auto* const of =
        problem ? static_cast<const bridge::FieldMethod::Problem*>(problem->internal) : nullptr;
    return of && of->isStopped && of->isStopped() ? 1 : 0;
}

/// A solver of the application.
class MethodOfCallback : public bridge::FieldMethod
{
public:
    MethodOfCallback(midair_solve_function solve, void* user) : _solve(solve), _user(user) {}

    bool solve(const Problem& given, std::complex<float>* activations, std::string& error) override
    {
        midair_problem problem{};
        problem.struct_size = sizeof problem;
        problem.points = given.points;
        problem.transducers = given.transducers;
        problem.positions = given.positions;
        problem.targets = given.targets;
        problem.matrix = reinterpret_cast<const float*>(given.matrix);
        problem.loudness = given.loudness;
        problem.deadline_ms = given.deadline_ms;
        problem.in_pascal = given.isAbsolute ? 1 : 0;
        problem.phase_only = given.phaseOnly ? 1 : 0;
        problem.max_iterations = given.maxIterations;
        problem.is_stopped = isStopped;
        problem.internal = &given;
        std::array<char, kErrorBytes> text{};
        const CallbackScope inside;
        const int32_t code = _solve(
            _user, &problem, reinterpret_cast<float*>(activations), text.data(), text.size() - 1);
        if (code != 0) error = textOf(text);
        return code == 0;
    }

private:
    const midair_solve_function _solve;
    void* const _user;
};

} // namespace

midair_status midair_register_device(const char* scheme, const midair_driver* driver)
{
    return called(
        [&]
        {
            const std::string name = textGiven(scheme, "scheme", 256);
            const midair_driver& all = given(driver, "driver");
            requireSize(all);
            if (!all.open || !all.play || !all.silence)
                fail(MIDAIR_INVALID, "open, play or silence is NULL");
            if (!(all.fields_per_second >= 0.0 && all.fields_per_second <= 1e9))
                fail(MIDAIR_INVALID,
                     fmt::format("fields_per_second is {:g}; it must be 0 .. 1e9",
                                 all.fields_per_second));
            if (all.phase_levels == 1 || all.phase_levels > 256)
                fail(MIDAIR_INVALID,
                     fmt::format("phase_levels is {}; it must be 0 or 2 .. 256", all.phase_levels));
            std::vector<float> amplitudes;
            if (all.amplitude_count > 256 || (all.amplitude_count > 0 && !all.amplitudes))
                fail(MIDAIR_INVALID,
                     fmt::format("amplitude_count is {}; it must be 0 .. 256, with amplitudes",
                                 all.amplitude_count));
            amplitudes.assign(all.amplitudes, all.amplitudes + all.amplitude_count);
            const auto make = [copy = all, amplitudes]
            { return std::make_shared<DriverOfCallbacks>(copy, amplitudes); };
            std::string error;
            if (!bridge::registerDriver(name, make, error)) fail(MIDAIR_REFUSED, error);
        });
}

midair_status midair_register_solver(const char* name, midair_solve_function solve, void* user)
{
    return called(
        [&]
        {
            const std::string registered = textGiven(name, "name", 256);
            if (!solve) fail(MIDAIR_INVALID, "solve is NULL");
            const auto make = [solve, user]
            { return std::make_shared<MethodOfCallback>(solve, user); };
            std::string error;
            if (!bridge::registerMethod(registered, make, error)) fail(MIDAIR_REFUSED, error);
        });
}
