#pragma once

#include "haptics/points/ControlPoints.h"
#include "haptics/propagation/RingingMean.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace midair::haptics
{

/// Options of a Modulator.
struct ModulatorOptions
{
    double amplitudeRate_Hz = 0.0; ///< 0 .. 500; frequency of the radiation pressure; 0: none
    /// 0 .. 1; the radiation pressure drops to 1 - depth of its maximum
    double amplitudeDepth = 1.0;
    double fieldRate_Hz = 1000.0; ///< 0.01 .. 40,000; fields per second, if there are several

    /// Returns false if a setting is out of range; \a error then names the first one.
    bool isValid(std::string* error = nullptr) const;
};

inline bool operator==(const ModulatorOptions& a, const ModulatorOptions& b)
{
    return a.amplitudeRate_Hz == b.amplitudeRate_Hz && a.amplitudeDepth == b.amplitudeDepth &&
           a.fieldRate_Hz == b.fieldRate_Hz;
}

/// Computes the field of a cycle to play at a time, and its amplitude: for amplitude modulation,
/// for fields in turn (a smoothed surface, or spatio-temporal modulation with a field for each
/// subset of the points), or for both.
class Modulator
{
public:
    /// Throws InputError for options that are not valid.
    explicit Modulator(const ModulatorOptions& options = {});

    /// A field, 0 .. fields - 1, and the factor on all its activations.
    using Step = PatternStep;

    /// Returns the step at \a time_s since the start (any finite time; before 0 the cycle runs
    /// backwards), for a cycle of \a fields >= 1. The amplitude makes the *pressure on the skin*
    /// follow
    ///     1 - depth (1 - cos(2 pi f t)) / 2,
    /// because radiation pressure is proportional to the square of the sound pressure.
    Step at(double time_s, int fields) const;

    /// Returns the steps at times 0, T, 2 T .. with T = 1/fieldRate_Hz, as sent to a device, until
    /// they repeat, for a cycle of \a fields >= 1; empty if that takes more than \a most steps.
    std::vector<Step> pattern(int fields, int most) const;
    /// Returns \a count of these steps, beginning with number \a first (any).
    std::vector<Step> steps(std::int64_t first, std::int64_t count, int fields) const;

    const ModulatorOptions& options() const { return _options; }
    /// Returns true if the output changes with time.
    bool changes(std::size_t fields) const { return fields > 1 || _options.amplitudeRate_Hz > 0.0; }

private:
    ModulatorOptions _options;
};

/// Divides points into \a count >= 1 subsets for spatio-temporal modulation. Every point is in
/// exactly one; their sizes differ by at most one. A greedy choice keeps the points of a subset far
/// apart, so that one field can make each of them strong.
std::vector<ControlPoints> subsetsInTurn(const ControlPoints& points, int count);

/// Returns the points with their targets at \a steps >= 2 instants of one period of an amplitude
/// modulation, in which each point has its own \a depth (n, 0 .. 1; 0: steady). The pressure on the
/// skin follows Modulator::at(). Points that are silent in a step are left out of it. Step j and
/// step steps - j are equal.
std::vector<ControlPoints>
modulationSteps(const ControlPoints& points, const Eigen::VectorXd& depth, int steps);

/// Limits field rates to the capacity of a device's line, for fields in turn and for modulation.
///
/// Each field sent is a sample of the modulation. Modulator's cosine needs four fields per period:
/// its top, its bottom and twice its half height; an array whose emitters are only on or off needs
/// two. If the line is slower than the requested field rate, the rate becomes the largest multiple
/// of the modulation frequency that fits, because other rates would beat with it.
///
/// A device that stores the fields of a period and times them itself doesn't need its line for
/// them: if the line is too slow, the rate is one that fits the store and the device's clock.
class LineRate
{
public:
    LineRate() = default; ///< no limit
    /// \a fieldsPerSecond >= 0; 0: no limit. \a onOff: emitters have no amplitudes between off and
    /// full. \a stored: maximum number of fields that the device times itself, 0: none, at rates of
    /// \a clock_Hz over a whole number, 0: any.
    LineRate(double fieldsPerSecond, bool onOff, int stored = 0, double clock_Hz = 0.0) :
        _carried(fieldsPerSecond),
        _aPeriod(onOff ? 2 : 4),
        _stored(stored),
        _clock_Hz(clock_Hz)
    {
    }

    /// Lowers the field rate of \a modulation to the line's capacity, for a modulation of \a
    /// frequency_Hz (0: none) of \a fields in turn. Throws base::InputError if the line is too
    /// slow. Returns the played frequency: the nearest one possible with the device's clock.
    double fit(ModulatorOptions& modulation, double frequency_Hz, int fields = 1) const;

    bool isSlowerThan(double fieldRate_Hz) const
    {
        return _carried > 0.0 && fieldRate_Hz > _carried;
    }
    /// Returns the message for fields that follow each other at the rate of \a played instead of \a
    /// asked.
    std::string message(const ModulatorOptions& played, const ModulatorOptions& asked) const;

private:
    double store(ModulatorOptions& modulation, double frequency_Hz, int fields) const;

    double _carried = 0.0; // fields per second; 0: no limit
    int _aPeriod = 4;
    int _stored = 0;
    double _clock_Hz = 0.0;
};

} // namespace midair::haptics
