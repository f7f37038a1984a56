#include "haptics/sequence/Modulator.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Range.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

// Keeps the times of far later steps within the range of the clock.
constexpr double kLeastFieldRate_Hz = 0.01;

// Rounds down, so that a text never promises too much.
double downToTenth(double value)
{
    return std::floor(10.0 * value) / 10.0;
}

// Boards store the ticks per step in a byte.
constexpr double kMostTicks = 255.0;

} // namespace

bool ModulatorOptions::isValid(std::string* error) const
{
    return base::RangeCheck()
        .within("amplitudeRate_Hz", amplitudeRate_Hz, 0.0, base::kMostModulation_Hz)
        .within("amplitudeDepth", amplitudeDepth, 0.0, 1.0)
        .within("fieldRate_Hz", fieldRate_Hz, kLeastFieldRate_Hz, base::kMostFieldRate_Hz)
        .passed(error);
}

Modulator::Modulator(const ModulatorOptions& options) : _options(options)
{
    std::string error;
    if (!options.isValid(&error)) throw base::InputError("modulator: " + error);
}

Modulator::Step Modulator::at(double time_s, int fields) const
{
    Step step;
    if (fields > 1)
    {
        // The margin keeps rounding from assigning the start of a field, computed as k / rate, to
        // the previous field.
        const double played = std::floor(time_s * _options.fieldRate_Hz + 1e-6);
        const double in = std::fmod(played, fields);
        step.field = static_cast<int>(in < 0.0 ? in + fields : in);
    }
    if (_options.amplitudeRate_Hz > 0.0)
    {
        const double pressure =
            1.0 - 0.5 * _options.amplitudeDepth *
                      (1.0 - std::cos(base::kTwoPi * _options.amplitudeRate_Hz * time_s));
        step.amplitude = std::sqrt(std::max(pressure, 0.0));
    }
    return step;
}

std::vector<Modulator::Step>
Modulator::steps(std::int64_t first, std::int64_t count, int fields) const
{
    std::vector<Step> all;
    for (std::int64_t k = first; k < first + count; ++k)
        all.push_back(at(static_cast<double>(k) / _options.fieldRate_Hz, fields));
    return all;
}

std::vector<Modulator::Step> Modulator::pattern(int fields, int most) const
{
    // A modulation off by this share of a period each period takes days to drift by one.
    constexpr double kWhole = 1e-9;
    std::int64_t period = 1;
    if (_options.amplitudeRate_Hz > 0.0)
    {
        const double exact = _options.fieldRate_Hz / _options.amplitudeRate_Hz;
        const double whole = std::round(exact);
        if (whole < 1.0 || whole > most || std::abs(exact - whole) > kWhole * whole) return {};
        period = static_cast<std::int64_t>(whole);
    }
    period = std::lcm(period, static_cast<std::int64_t>(fields));
    return period > most ? std::vector<Step>() : steps(0, period, fields);
}

std::vector<ControlPoints> subsetsInTurn(const ControlPoints& points, int count)
{
    if (count < 1)
        throw base::InputError(
            fmt::format("subsets in turn: {} subsets; there must be at least one", count));
    const int n = points.size();
    std::vector<std::vector<int>> subsets(
        static_cast<std::size_t>(std::max(1, std::min(count, n))));
    std::vector<unsigned char> taken(static_cast<std::size_t>(n), 0);
    // The subsets take turns; each takes the point farthest from its own.
    Eigen::MatrixXd nearest2 = Eigen::MatrixXd::Constant(
        n, static_cast<Eigen::Index>(subsets.size()), std::numeric_limits<double>::max());
    for (int given = 0; given < n; ++given)
    {
        const auto s = static_cast<std::size_t>(given) % subsets.size();
        const auto column = static_cast<Eigen::Index>(s);
        int best = -1;
        for (int l = 0; l < n; ++l)
            if (!taken[static_cast<std::size_t>(l)] &&
                (best < 0 || nearest2(l, column) > nearest2(best, column)))
                best = l;
        taken[static_cast<std::size_t>(best)] = 1;
        subsets[s].push_back(best);
        for (int l = 0; l < n; ++l)
            nearest2(l, column) =
                std::min(nearest2(l, column),
                         (points.positions.col(l) - points.positions.col(best)).squaredNorm());
    }
    std::vector<ControlPoints> result;
    result.reserve(subsets.size());
    for (const std::vector<int>& subset : subsets)
        result.push_back(pick(points, subset));
    return result;
}

std::vector<ControlPoints>
modulationSteps(const ControlPoints& points, const Eigen::VectorXd& depth, int steps)
{
    if (steps < 2)
        throw base::InputError(
            fmt::format("modulation: {} steps a period; there must be at least two", steps));
    if (depth.size() != points.size() || !(depth.array() >= 0.0 && depth.array() <= 1.0).all())
        throw base::InputError(
            "modulation: there must be a depth of 0 .. 1 for each control point");
    constexpr double kSilent = 1e-3; // fraction of the target
    std::vector<ControlPoints> result;
    for (int j = 0; j < steps; ++j)
    {
        const double down = 0.5 * (1.0 - std::cos(base::kTwoPi * j / steps));
        const Eigen::VectorXd share = (1.0 - depth.array() * down).max(0.0).sqrt();
        std::vector<int> heard;
        for (int l = 0; l < points.size(); ++l)
            if (share[l] > kSilent) heard.push_back(l);
        result.push_back(pick(points, heard));
        for (std::size_t l = 0; l < heard.size(); ++l)
            result.back().targets[static_cast<Eigen::Index>(l)] *= share[heard[l]];
    }
    return result;
}

// Returns the played frequency; 0: it can't be stored. Among the possible numbers of steps per
// period, takes the one with the nearest frequency, and of those the largest.
double LineRate::store(ModulatorOptions& modulation, double frequency_Hz, int fields) const
{
    double best_Hz = 0.0;
    double stored_Hz = 0.0;
    for (int steps = _aPeriod; steps <= _stored; ++steps)
    {
        if (std::lcm(steps, fields) > _stored) continue;
        double rate_Hz = steps * frequency_Hz;
        if (steps > _aPeriod && rate_Hz > modulation.fieldRate_Hz) break;
        if (_clock_Hz > 0.0) rate_Hz = _clock_Hz / std::max(1.0, std::round(_clock_Hz / rate_Hz));
        if (_clock_Hz > 0.0 && rate_Hz * kMostTicks < _clock_Hz) continue;
        const double played_Hz = rate_Hz / steps;
        if (best_Hz > 0.0 && std::abs(played_Hz - frequency_Hz) >
                                 std::abs(best_Hz - frequency_Hz) + 1e-9 * frequency_Hz)
            continue;
        best_Hz = played_Hz;
        stored_Hz = rate_Hz;
    }
    if (best_Hz > 0.0) modulation.fieldRate_Hz = stored_Hz;
    return best_Hz;
}

double LineRate::fit(ModulatorOptions& modulation, double frequency_Hz, int fields) const
{
    if (_carried <= 0.0) return frequency_Hz;
    const bool isTooSlow =
        _carried < _aPeriod * frequency_Hz || isSlowerThan(modulation.fieldRate_Hz);
    if (isTooSlow && frequency_Hz > 0.0)
        if (const double stored_Hz = store(modulation, frequency_Hz, fields); stored_Hz > 0.0)
            return stored_Hz;
    if (_carried < _aPeriod * frequency_Hz)
        throw base::InputError(fmt::format(
            "modulation of {:g} Hz needs {:g} fields/s; the device carries {:g}: at most {:g} Hz",
            frequency_Hz,
            _aPeriod * frequency_Hz,
            downToTenth(_carried),
            downToTenth(_carried / _aPeriod)));
    if (isSlowerThan(modulation.fieldRate_Hz))
        modulation.fieldRate_Hz =
            frequency_Hz > 0.0 ? frequency_Hz * std::floor(_carried / frequency_Hz) : _carried;
    return frequency_Hz;
}

std::string LineRate::message(const ModulatorOptions& played, const ModulatorOptions& asked) const
{
    return fmt::format(
        "fields in turn follow each other at {:g} a second, not {:g}: the device carries {:g}",
        played.fieldRate_Hz,
        asked.fieldRate_Hz,
        downToTenth(_carried));
}

} // namespace midair::haptics
