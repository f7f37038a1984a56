#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/sequence/FieldSequence.h"

#include <Eigen/Core>

#include <complex>
#include <cstdint>
#include <string>
#include <vector>

namespace midair::haptics
{

/// One of a schedule's drives, times \a amplitude, for \a duration_s.
struct ScheduledDrive
{
    int drive = 0;           ///< index, from 0
    double amplitude = 1.0;  ///< 0 .. 1
    double duration_s = 0.0; ///< above 0
};

/// What an array is driven with over time.
struct DriveSchedule
{
    std::vector<Eigen::VectorXcf> drives; ///< m activations each, |q_i| <= 1
    std::vector<ScheduledDrive> steps;    ///< >= 1, in the order in which they are played
    double begin_s = 0.0;                 ///< when the first of them begins
    /// True: the steps repeat, before their beginning, too, so that all is settled at any time.
    /// False: before the first the array is silent, and the last is held for ever.
    bool repeats = true;

    /// Returns the length of all steps together.
    double duration_s() const;
    /// Returns false if there are no steps, lengths or indices disagree, or a number is not finite
    /// or out of range; \a error then says which.
    bool isValid(std::string* error = nullptr) const;
};

/// Returns \a sequence as a device plays it from time 0 to \a until_s (0 .. 3600) at least: fields
/// in turn at its field rate, each with the amplitude of its modulation when it begins. It repeats
/// where fields and modulation do within 65536 steps; else it begins 0.2 s before, when all
/// transducers have long settled. Throws InputError for no fields, options out of range, and more
/// than 10^7 steps.
DriveSchedule stepsOf(const FieldSequence& sequence, double until_s);

/// When a probe looks, and how.
struct ProbeOptions
{
    double rate_Hz = 20e3;   ///< 1 .. 1e6; samples per second
    double begin_s = 0.0;    ///< -3600 .. 3600; time of the first sample
    double duration_s = 1.0; ///< above 0, at most 3600; it takes 1 .. 10^8 samples
    base::StopToken stop;    ///< Stopped is thrown if it requests a stop

    int samples() const; ///< duration_s rate_Hz, rounded, at least 1
    /// Returns false if a setting is out of range; \a error then names the first one.
    bool isValid(std::string* error = nullptr) const;
};

/// The pressure at any point over time while a schedule is played: transducers ring and sound takes
/// its time. The envelope of transducer i follows its drive, which goes from q0 to q1 at time 0,
/// with
///     a_i(t) = q1 + (q0 - q1) e^{-t/tau}
/// (a second-order resonance of quality pi f tau, driven at it: within 2 % of the full circuit of a
/// T4010A1, see TransducerArray::ringing_s), and at a point r
///     p(r, t) = sum_i G_i(r) a_i(t - R_i/c),
/// the complex envelope at the array's frequency, peak, with G as ReferencePropagation has it, in
/// double. Where no change is on its way and nothing rings (tau = 0) that is the steady field bit
/// for bit: the sum over i in order, times the step's amplitude.
///
/// Exact for each single switch of each transducer, whatever the rate of samples. Immutable; any
/// thread.
class PressureProbe
{
public:
    /// Throws InputError for an array or a schedule that isn't valid, or not of one size.
    PressureProbe(const TransducerArray& array, const Medium& medium, DriveSchedule schedule);

    /// Returns p at \a point (m, array frame), one for each sample, at begin_s + k/rate_Hz. Throws
    /// InputError for options out of range and a point that is not finite.
    Eigen::VectorXcd at(const Eigen::Vector3d& point, const ProbeOptions& options) const;

    /// Returns the steady field of each drive at \a point.
    std::vector<std::complex<double>> steadyAt(const Eigen::Vector3d& point) const;

private:
    struct Arrivals;
    struct Course;
    class Passage;

    Arrivals arrivalsAt(const Eigen::Vector3d& point) const;
    Course courseOf(double from_s, double to_s) const;
    double timeOf(std::int64_t step) const;

    TransducerArray _array;
    Medium _medium;
    DriveSchedule _schedule;
    std::vector<double> _begin_s; // of each step after the first's, then of all together
};

/// Returns the radiation pressure in Pa of each of \a pressure_Pa (complex, peak).
Eigen::VectorXd
radiationOf(const Eigen::VectorXcd& pressure_Pa, const Medium& medium, double alpha = 2.0);

/// Amplitudes of the parts of something over time, by frequency.
struct Spectrum
{
    double step_Hz = 0.0; ///< between one frequency and the next; the first is 0
    /// Half as many as samples, and one. A lasting sine of amplitude A at one of the frequencies
    /// is A there, and half of that beside it (Hann's window); the mean is the first.
    Eigen::VectorXd amplitude;
};

/// Returns the spectrum of \a values (2 or more, finite), sampled at \a rate_Hz (above 0). It takes
/// the first of them, as many as have no prime factor above 5, under Hann's window. Lines are sharp
/// where what repeats does so a whole number of times in these. Throws InputError for what can't be
/// taken.
Spectrum spectrumOf(const Eigen::VectorXd& values, double rate_Hz);

/// Returns the largest number up to \a most (>= 1) without a prime factor above 5.
Eigen::Index smoothLength(Eigen::Index most);

} // namespace midair::haptics
