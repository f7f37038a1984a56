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

/// One drive of a schedule, times \a amplitude, for \a duration_s.
struct ScheduledDrive
{
    int drive = 0;           ///< index, from 0
    double amplitude = 1.0;  ///< 0 .. 1
    double duration_s = 0.0; ///< above 0
};

/// Drive of an array over time.
struct DriveSchedule
{
    std::vector<Eigen::VectorXcf> drives; ///< m activations each, |q_i| <= 1
    std::vector<ScheduledDrive> steps;    ///< >= 1, in the order in which they are played
    double begin_s = 0.0;                 ///< start of the first step
    /// True: the steps repeat, also before begin_s, so the array is always settled. False: silent
    /// before the first step, and the last is held forever.
    bool repeats = true;

    /// Returns the total length of all steps.
    double duration_s() const;
    /// Returns false if there are no steps, lengths or indices disagree, or a number is not finite
    /// or out of range; \a error then names it.
    bool isValid(std::string* error = nullptr) const;
};

/// Returns \a sequence as a device plays it from time 0 to at least \a until_s (0 .. 3600): fields
/// in turn at its field rate, each with the modulation's amplitude at its start. It repeats if
/// fields and modulation repeat within 65536 steps; otherwise it begins 0.2 s early, so that all
/// transducers have settled. Throws InputError for no fields, options out of range, and more than
/// 10^7 steps.
DriveSchedule stepsOf(const FieldSequence& sequence, double until_s);

/// Sampling options of a probe.
struct ProbeOptions
{
    double rate_Hz = 20e3;   ///< 1 .. 1e6; samples per second
    double begin_s = 0.0;    ///< -3600 .. 3600; time of the first sample
    double duration_s = 1.0; ///< above 0, at most 3600; gives 1 .. 10^8 samples
    base::StopToken stop;    ///< on its request Stopped is thrown

    int samples() const; ///< duration_s rate_Hz, rounded, at least 1
    /// Returns false if a setting is out of range; \a error then names the first one.
    bool isValid(std::string* error = nullptr) const;
};

/// Pressure at any point over time while a schedule plays, with ringing and travel time of sound.
/// The envelope of transducer i follows its drive, which changes from q0 to q1 at time 0, with
///     a_i(t) = q1 + (q0 - q1) e^{-t/tau}
/// (a second-order resonance of quality pi f tau, driven at it: within 2 % of the full circuit of a
/// T4010A1, see TransducerArray::ringing_s), and at a point r
///     p(r, t) = sum_i G_i(r) a_i(t - R_i/c),
/// the complex envelope at the array's frequency, peak, with G as in ReferencePropagation, in
/// double. When no change is travelling and nothing rings (tau = 0) it equals the steady field bit
/// for bit: the sum over i in order, times the step's amplitude.
///
/// Exact for each single switch of each transducer, whatever the rate of samples. Immutable; any
/// thread.
class PressureProbe
{
public:
    /// Throws InputError for an invalid array or schedule, or if their sizes differ.
    PressureProbe(const TransducerArray& array, const Medium& medium, DriveSchedule schedule);

    /// Returns p at \a point (m, array frame), one value per sample, at begin_s + k/rate_Hz. Throws
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
    std::vector<double> _begin_s; // of each step after the first, then of the whole
};

/// Returns the radiation pressure in Pa of each \a pressure_Pa (complex, peak).
Eigen::VectorXd
radiationOf(const Eigen::VectorXcd& pressure_Pa, const Medium& medium, double alpha = 2.0);

/// Amplitude spectrum of a signal.
struct Spectrum
{
    double step_Hz = 0.0; ///< frequency spacing; the first is 0
    /// Half the number of samples, plus one. A lasting sine of amplitude A at one of the
    /// frequencies gives A there and half of it beside (Hann window); the first is the mean.
    Eigen::VectorXd amplitude;
};

/// Returns the spectrum of \a values (2 or more, finite), sampled at \a rate_Hz (above 0). Uses the
/// largest leading part whose length has no prime factor above 5, with a Hann window. Lines are
/// sharp if the signal repeats a whole number of times in it. Throws InputError for invalid input.
Spectrum spectrumOf(const Eigen::VectorXd& values, double rate_Hz);

/// Returns the largest number up to \a most (>= 1) without a prime factor above 5.
Eigen::Index smoothLength(Eigen::Index most);

} // namespace midair::haptics
