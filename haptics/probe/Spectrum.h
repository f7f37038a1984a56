#pragma once

#include <Eigen/Core>

namespace midair::haptics
{

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
