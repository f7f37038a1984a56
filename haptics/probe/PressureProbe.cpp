#include "haptics/probe/PressureProbe.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Range.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/ReferencePropagation.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numeric>
#include <vector>

#include <fmt/format.h>
#include <unsupported/Eigen/FFT>

namespace midair::haptics
{

namespace
{

constexpr int kMostRepeated = 65536;
constexpr double kMostSteps = 1e7;    // 240 MB of them
constexpr double kLongest_s = 3600.0; // of a schedule that doesn't repeat
constexpr double kRunUp_s = 20.0 * kMostRinging_s;

std::string wrongStep(const ScheduledDrive& step, std::size_t drives)
{
    if (step.drive < 0 || static_cast<std::size_t>(step.drive) >= drives)
        return fmt::format("plays drive {}, but there are {}, from 0", step.drive, drives);
    if (!(step.amplitude >= 0.0 && step.amplitude <= 1.0))
        return fmt::format("has the amplitude {:g}; it must be within 0 .. 1", step.amplitude);
    if (!(step.duration_s > 0.0) || !std::isfinite(step.duration_s))
        return fmt::format("lasts {:g} s; it must be above 0", step.duration_s);
    return {};
}

using Complex = std::complex<double>;

constexpr double kFarthest_s = 3600.0;
constexpr double kMostSamples = 1e8;
// After this many time constants a change has vanished, in double precision.
constexpr double kRungOut = 40.0;

} // namespace

double DriveSchedule::duration_s() const
{
    double sum_s = 0.0;
    for (const ScheduledDrive& step : steps)
        sum_s += step.duration_s;
    return sum_s;
}

bool DriveSchedule::isValid(std::string* error) const
{
    std::string text;
    if (drives.empty() || steps.empty())
        text = "there are no drives or no steps; there must be at least one of each";
    else if (!std::isfinite(begin_s))
        text = fmt::format("it begins at {:g} s; it must begin at a time", begin_s);
    for (std::size_t k = 0; k < drives.size() && text.empty(); ++k)
        if (drives[k].size() != drives.front().size())
            text = fmt::format("drive {} is for {} transducers, drive 0 for {}",
                               k,
                               drives[k].size(),
                               drives.front().size());
        else if (!drives[k].allFinite())
            text = fmt::format("an activation of drive {} is not finite", k);
    for (std::size_t k = 0; k < steps.size() && text.empty(); ++k)
        if (const std::string wrong = wrongStep(steps[k], drives.size()); !wrong.empty())
            text = fmt::format("step {} {}", k, wrong);
    if (error != nullptr) *error = text;
    return text.empty();
}

DriveSchedule stepsOf(const FieldSequence& sequence, double until_s)
{
    if (sequence.isEmpty())
        throw base::InputError("schedule: there are no fields; there must be at least one");
    if (!(until_s >= 0.0 && until_s <= kLongest_s))
        throw base::InputError(
            fmt::format("schedule: {:g} s are asked for; it must be 0 .. 3600 s", until_s));
    const Modulator modulator(sequence.modulation);
    const int fields = static_cast<int>(sequence.fields.size());
    const double rate_Hz = sequence.modulation.fieldRate_Hz;
    DriveSchedule schedule;
    schedule.drives = sequence.fields;
    std::vector<Modulator::Step> steps = modulator.pattern(fields, kMostRepeated);
    if (steps.empty())
    {
        const double runUp = std::ceil(kRunUp_s * rate_Hz);
        const double count = runUp + std::ceil(until_s * rate_Hz) + 1.0;
        if (count > kMostSteps)
            throw base::InputError(fmt::format("schedule: {:g} s at {:g} fields/s are more than "
                                               "{:g} steps, which is the most possible",
                                               until_s,
                                               rate_Hz,
                                               kMostSteps));
        const auto first = -static_cast<std::int64_t>(runUp);
        schedule.repeats = false;
        schedule.begin_s = -runUp / rate_Hz;
        steps = modulator.steps(first, static_cast<std::int64_t>(count), fields);
    }
    for (const Modulator::Step& step : steps)
        schedule.steps.push_back({step.field, step.amplitude, 1.0 / rate_Hz});
    return schedule;
}

int ProbeOptions::samples() const
{
    return std::max(1, static_cast<int>(std::lround(duration_s * rate_Hz)));
}

bool ProbeOptions::isValid(std::string* error) const
{
    return base::RangeCheck("probe: ")
        .within("rate_Hz", rate_Hz, 1.0, 1e6)
        .within("begin_s", begin_s, -kFarthest_s, kFarthest_s)
        .above("duration_s", duration_s, 0.0)
        .within("duration_s", duration_s, 0.0, kFarthest_s)
        .within("samples", duration_s * rate_Hz, 0.0, kMostSamples)
        .passed(error);
}

// The ways of sound in the order in which it arrives at a point.
struct PressureProbe::Arrivals
{
    Eigen::RowVectorXcd G; // in the array's order
    std::vector<SoundPath> order;
    std::vector<double> delay_s; // of each arrival, ascending
    std::vector<double> left;    // remaining share of the ringing at the previous arrival
};

// The switches between steps within a time span, and the step before the first of them.
struct PressureProbe::Course
{
    struct Switch
    {
        double time_s;
        int from, to; // steps; -1: silence
    };
    int before = -1;
    std::vector<Switch> switches;
};

PressureProbe::PressureProbe(const TransducerArray& array,
                             const Medium& medium,
                             DriveSchedule schedule) :
    _array(array),
    _medium(medium),
    _schedule(std::move(schedule))
{
    std::string error;
    if (!_array.isValid(&error) || !_medium.isValid(&error))
        throw base::InputError("probe: " + error);
    if (!_schedule.isValid(&error)) throw base::InputError("probe: schedule: " + error);
    if (_schedule.drives.front().size() != _array.size())
        throw base::InputError("probe: the schedule's drives are for " +
                               std::to_string(_schedule.drives.front().size()) +
                               " transducers, the array has " + std::to_string(_array.size()));
    _begin_s.push_back(0.0);
    for (const ScheduledDrive& step : _schedule.steps)
        _begin_s.push_back(_begin_s.back() + step.duration_s);
}

PressureProbe::Arrivals PressureProbe::arrivalsAt(const Eigen::Vector3d& point) const
{
    Arrivals arrivals;
    arrivals.G = referencePropagationMatrix(point, _array, _medium).row(0);
    arrivals.order = referencePaths(point, _array, _medium);
    std::stable_sort(arrivals.order.begin(),
                     arrivals.order.end(),
                     [](const SoundPath& a, const SoundPath& b)
                     { return a.length_m < b.length_m; });
    for (const SoundPath& path : arrivals.order)
    {
        const double delay_s = path.length_m / _medium.soundSpeed();
        const double since_s = arrivals.delay_s.empty() ? 0.0 : delay_s - arrivals.delay_s.back();
        arrivals.delay_s.push_back(delay_s);
        arrivals.left.push_back(_array.ringing_s > 0.0 ? std::exp(-since_s / _array.ringing_s)
                                                       : 0.0);
    }
    return arrivals;
}

// Start of a step; steps of a repeating schedule have increasing numbers, from -1 downwards before
// it.
double PressureProbe::timeOf(std::int64_t step) const
{
    const auto N = static_cast<std::int64_t>(_schedule.steps.size());
    const std::int64_t round = step >= 0 ? step / N : -((-step + N - 1) / N);
    return _schedule.begin_s + static_cast<double>(round) * _begin_s.back() +
           _begin_s[static_cast<std::size_t>(step - round * N)];
}

PressureProbe::Course PressureProbe::courseOf(double from_s, double to_s) const
{
    const auto N = static_cast<std::int64_t>(_schedule.steps.size());
    std::int64_t next = 0;
    if (_schedule.repeats)
        next = N * static_cast<std::int64_t>(
                       std::floor((from_s - _schedule.begin_s) / _begin_s.back()) - 1.0);
    const auto index = [&](std::int64_t step)
    {
        const std::int64_t in = step % N;
        return static_cast<int>(in < 0 ? in + N : in);
    };
    Course course;
    course.before = _schedule.repeats ? index(next - 1) : -1;
    for (; _schedule.repeats || next < N; ++next)
    {
        const double time_s = timeOf(next);
        if (time_s >= to_s) break;
        const int from = course.switches.empty() ? course.before : course.switches.back().to;
        const int to = index(next);
        const bool isSame = from >= 0 &&
                            _schedule.steps[static_cast<std::size_t>(from)].drive ==
                                _schedule.steps[static_cast<std::size_t>(to)].drive &&
                            _schedule.steps[static_cast<std::size_t>(from)].amplitude ==
                                _schedule.steps[static_cast<std::size_t>(to)].amplitude;
        if (time_s < from_s)
            course.before = to;
        else if (!isSame)
            course.switches.push_back({time_s, from, to});
    }
    return course;
}

// Follows the switches past a point. While a switch arrives, its share of the pressure is S + E: S
// is the final value of its arrivals, E the decaying difference from it. Shares add up, for any
// number of overlapping switches.
class PressureProbe::Passage
{
public:
    Passage(const PressureProbe& probe,
            const Arrivals& arrivals,
            const ProbeOptions& options,
            Eigen::VectorXcd& pressure_Pa) :
        _probe(probe),
        _arrivals(arrivals),
        _options(options),
        _pressure_Pa(pressure_Pa),
        _tau_s(probe._array.ringing_s),
        _before(arrivals.order.size()),
        _after(arrivals.order.size())
    {
        for (const Eigen::VectorXcf& q : probe._schedule.drives)
        {
            Complex sum = 0.0;
            for (Eigen::Index i = 0; i < q.size(); ++i)
                sum += arrivals.G[i] * Complex(q[i]);
            _steady.push_back(sum);
        }
    }

    void begin(int step) { drive(step, _after); }
    const std::vector<Complex>& steadyOfDrives() const { return _steady; }

    // Adds the share of a switch to the samples between its first and last arrival, and returns
    // what rings on afterwards.
    Complex arrive(const Course::Switch& now)
    {
        _before.swap(_after);
        drive(now.to, _after);
        const std::size_t m = _after.size();
        int sample = firstSampleFrom(now.time_s + _arrivals.delay_s.front());
        double sampleTime_s = timeOf(sample);
        Complex S = 0.0, E = 0.0;
        for (std::size_t i = 0; i < m; ++i)
        {
            const double arrival_s = now.time_s + _arrivals.delay_s[i];
            while (sampleTime_s < arrival_s)
            {
                if (sample < _pressure_Pa.size())
                    _pressure_Pa[sample] +=
                        S + E * left(sampleTime_s - now.time_s - _arrivals.delay_s[i - 1]);
                sampleTime_s = timeOf(++sample);
            }
            const Complex change = _after[i] - _before[i];
            S += change;
            E = {E.real() * _arrivals.left[i] - change.real(),
                 E.imag() * _arrivals.left[i] - change.imag()};
        }
        return _tau_s > 0.0 ? E : 0.0;
    }

    // Remaining share of a decaying value after \a time_s.
    double left(double time_s) const { return _tau_s > 0.0 ? std::exp(-time_s / _tau_s) : 0.0; }

    double timeOf(int sample) const
    {
        return _options.begin_s + static_cast<double>(sample) / _options.rate_Hz;
    }

    // The steady field of a step, bit for bit that of its drive.
    Complex steady(int step) const
    {
        if (step < 0) return 0.0;
        const ScheduledDrive& now = _probe._schedule.steps[static_cast<std::size_t>(step)];
        return now.amplitude * _steady[static_cast<std::size_t>(now.drive)];
    }

private:
    // Index of the first sample at or after \a time_s, at least 0.
    int firstSampleFrom(double time_s) const
    {
        const double sample = std::ceil((time_s - _options.begin_s) * _options.rate_Hz);
        int first =
            static_cast<int>(std::clamp(sample, 0.0, static_cast<double>(_pressure_Pa.size())));
        // Rounding can be off by one.
        while (first > 0 && timeOf(first - 1) >= time_s)
            --first;
        while (first < _pressure_Pa.size() && timeOf(first) < time_s)
            ++first;
        return first;
    }

    // Final contribution of each arrival of a step.
    void drive(int step, std::vector<Complex>& brings) const
    {
        if (step < 0) return std::fill(brings.begin(), brings.end(), Complex(0.0));
        const ScheduledDrive& now = _probe._schedule.steps[static_cast<std::size_t>(step)];
        const Eigen::VectorXcf& q = _probe._schedule.drives[static_cast<std::size_t>(now.drive)];
        for (std::size_t k = 0; k < brings.size(); ++k)
        {
            const int i = _arrivals.order[k].transducer;
            const Complex g = now.amplitude * _arrivals.order[k].entry;
            const double re = q[i].real(), im = q[i].imag();
            brings[k] = {g.real() * re - g.imag() * im, g.real() * im + g.imag() * re};
        }
    }

    const PressureProbe& _probe;
    const Arrivals& _arrivals;
    const ProbeOptions& _options;
    Eigen::VectorXcd& _pressure_Pa;
    double _tau_s;
    std::vector<Complex> _before, _after; // of a switch, in the order of arrival
    std::vector<Complex> _steady;         // of each drive
};

Eigen::VectorXcd PressureProbe::at(const Eigen::Vector3d& point, const ProbeOptions& options) const
{
    std::string error;
    if (!options.isValid(&error)) throw base::InputError(error);
    if (!point.allFinite())
        throw base::InputError("probe: a coordinate of the point is not finite");
    const Arrivals arrivals = arrivalsAt(point);
    const double first_s = arrivals.delay_s.front(), last_s = arrivals.delay_s.back();
    const int samples = options.samples();
    const Course course =
        courseOf(options.begin_s - last_s - kRungOut * _array.ringing_s,
                 options.begin_s + static_cast<double>(samples) / options.rate_Hz - first_s);

    Eigen::VectorXcd pressure_Pa = Eigen::VectorXcd::Zero(samples);
    Passage passage(*this, arrivals, options, pressure_Pa);
    passage.begin(course.before);
    // The sum of all arrived shares is the steady field of the last such step, plus all ringing.
    Complex steady = passage.steady(course.before), rings = 0.0;
    double since_s = 0.0;
    int sample = 0;
    const auto fillUntil = [&](double end_s)
    {
        for (; sample < samples && passage.timeOf(sample) < end_s; ++sample)
        {
            pressure_Pa[sample] += steady;
            if (rings != 0.0)
                pressure_Pa[sample] += rings * passage.left(passage.timeOf(sample) - since_s);
        }
    };
    for (const Course::Switch& now : course.switches)
    {
        options.stop.throwIfRequested();
        const Complex left = passage.arrive(now);
        const double end_s = now.time_s + last_s;
        fillUntil(end_s);
        steady = passage.steady(now.to);
        rings = rings == 0.0 ? left : rings * passage.left(end_s - since_s) + left;
        since_s = end_s;
    }
    fillUntil(INFINITY);
    return pressure_Pa;
}

std::vector<Complex> PressureProbe::steadyAt(const Eigen::Vector3d& point) const
{
    if (!point.allFinite())
        throw base::InputError("probe: a coordinate of the point is not finite");
    const Arrivals arrivals = arrivalsAt(point);
    Eigen::VectorXcd none;
    return Passage(*this, arrivals, {}, none).steadyOfDrives();
}

Eigen::VectorXd radiationOf(const Eigen::VectorXcd& pressure_Pa, const Medium& medium, double alpha)
{
    return radiationPressure(1.0, medium, alpha) * pressure_Pa.cwiseAbs2();
}

Eigen::Index smoothLength(Eigen::Index most)
{
    Eigen::Index best = 1;
    for (Eigen::Index fives = 1; fives <= most; fives *= 5)
        for (Eigen::Index threes = fives; threes <= most; threes *= 3)
        {
            Eigen::Index twos = threes;
            while (2 * twos <= most)
                twos *= 2;
            best = std::max(best, twos);
        }
    return best;
}

Spectrum spectrumOf(const Eigen::VectorXd& values, double rate_Hz)
{
    if (values.size() < 2)
        throw base::InputError(
            fmt::format("spectrum: {} values; there must be at least 2", values.size()));
    if (!values.allFinite()) throw base::InputError("spectrum: a value is not finite");
    if (!(rate_Hz > 0.0) || !std::isfinite(rate_Hz))
        throw base::InputError(
            fmt::format("spectrum: the rate is {:g} Hz; it must be above 0", rate_Hz));

    const Eigen::Index n = smoothLength(values.size());
    // Without the mean, which the window would spread into the first frequencies.
    const double mean = values.head(n).mean();
    std::vector<double> windowed;
    double sum = 0.0;
    for (Eigen::Index k = 0; k < n; ++k)
    {
        const double share = static_cast<double>(k) / static_cast<double>(n);
        const double window = 0.5 - 0.5 * std::cos(base::kTwoPi * share);
        windowed.push_back(window * (values[k] - mean));
        sum += window;
    }
    std::vector<std::complex<double>> lines;
    Eigen::FFT<double> transform;
    transform.fwd(lines, windowed);
    Spectrum spectrum;
    spectrum.step_Hz = rate_Hz / static_cast<double>(n);
    spectrum.amplitude.resize(n / 2 + 1);
    for (Eigen::Index k = 0; k < spectrum.amplitude.size(); ++k)
        spectrum.amplitude[k] = 2.0 / sum * std::abs(lines[static_cast<std::size_t>(k)]);
    spectrum.amplitude[0] = std::fabs(mean);
    return spectrum;
}

} // namespace midair::haptics
