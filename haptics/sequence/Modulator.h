#pragma once

#include "haptics/points/ControlPoints.h"

#include <cstddef>
#include <string>
#include <vector>

namespace midair::haptics
{

/// How a field, or a cycle of fields, is modulated; isValid() names the first setting that is out
/// of its range.
struct ModulatorOptions
{
    double amplitudeRate_Hz = 0.0; ///< 0 .. 500; of the radiation pressure; 0: none
    double amplitudeDepth = 1.0;   ///< 0 .. 1; 1: down to silence
    double fieldRate_Hz = 1000.0;  ///< 0.01 .. 40,000; fields a second, where there are several

    bool isValid(std::string* error = nullptr) const;
};

inline bool operator==(const ModulatorOptions& a, const ModulatorOptions& b)
{
    return a.amplitudeRate_Hz == b.amplitudeRate_Hz && a.amplitudeDepth == b.amplitudeDepth &&
           a.fieldRate_Hz == b.fieldRate_Hz;
}

/// Says which field of a cycle, and how strong, is to be played at a time: amplitude modulation,
/// fields in turn (a smoothed surface, or spatio-temporal modulation, where each is for a subset of
/// the points), or both.
class Modulator
{
public:
    /// Throws InputError for options that are not valid.
    explicit Modulator(const ModulatorOptions& options = {});

    struct Step
    {
        int field = 0;          ///< 0 .. fields - 1
        double amplitude = 1.0; ///< 0 .. 1; factor on all activations
    };

    /// What is played at \a time_s since the start (any finite time; before 0 the cycle runs
    /// backwards), for a cycle of \a fields >= 1. The amplitude makes the *pressure on the skin*
    /// follow
    ///     1 - depth (1 - cos(2 pi f t)) / 2,
    /// since radiation pressure goes with the square of the sound pressure.
    Step at(double time_s, int fields) const;

    const ModulatorOptions& options() const { return _options; }
    /// Whether what is to be played changes with time.
    bool changes(std::size_t fields) const { return fields > 1 || _options.amplitudeRate_Hz > 0.0; }

private:
    ModulatorOptions _options;
};

/// Divides points into \a count >= 1 subsets for spatio-temporal modulation. Every point is in
/// exactly one; their sizes differ by at most one. The points of a subset are as far apart as a
/// greedy choice gets them, so that one field can make each of them strong.
std::vector<ControlPoints> subsetsInTurn(const ControlPoints& points, int count);

/// \a steps >= 2 sets of targets through one period of an amplitude modulation in which each point
/// takes part by its own \a depth (n, 0 .. 1; 0: steady): the pressure on the skin goes as
/// Modulator::at says. Points that are silent in a step are left out of it. Step j and step steps -
/// j are alike.
std::vector<ControlPoints>
modulationSteps(const ControlPoints& points, const Eigen::VectorXd& depth, int steps);

} // namespace midair::haptics
