#pragma once

#include "haptics/base/Percentile.h"
#include "haptics/base/Units.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/tuning/RehearsedInstrument.h"
#include "haptics/tuning/TuningFit.h"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

namespace midair::haptics
{

/// How near a fit came to what a rehearsal hid.
struct TuningAccuracy
{
    double phaseError_rad = 0.0; ///< rms over transducers found alive, but for a common phase
    int reversedWrong = 0;       ///< off by more than 90 degrees: of the other polarity
    int dead = 0;                ///< hidden
    int deadFound = 0;           ///< of those
    int deadWrong = 0;           ///< alive, and called dead
    double gainError = 0.0;      ///< rms, relative to the median gain
    /// Least amplitude of a focus with the found offsets, over that with the hidden ones, of foci
    /// at the first place and 2 cm beside it along each axis.
    double focus = 0.0;
    Eigen::Matrix3Xd placeErrors_m; ///< 3 x P, found less hidden
};

// The waves of a focus arrive with the errors of the offsets: |sum |G| e^{j (true - found)}| over
// sum |G|; what is called dead doesn't play.
inline double
focusOf(const TuningFit& fit, const TransducerArray& truth, const Eigen::Vector3d& place)
{
    const Eigen::MatrixXcd G = referencePropagationMatrix(place, truth, {});
    std::complex<double> sum = 0.0;
    double all = 0.0;
    for (Eigen::Index i = 0; i < G.cols(); ++i)
    {
        all += std::abs(G(0, i));
        if (fit.array.gain[i] > 0.0)
            sum += std::polar(std::abs(G(0, i)),
                              truth.phaseOffset_rad[i] - fit.array.phaseOffset_rad[i]);
    }
    return std::abs(sum) / all;
}

inline TuningAccuracy accuracyOf(const TuningFit& fit, const RehearsedInstrument& hidden)
{
    constexpr double kBeside_m = 0.02;
    TuningAccuracy accuracy;
    const TransducerArray& truth = hidden.truth();
    std::vector<bool> isDead(static_cast<std::size_t>(truth.size()), false);
    for (const int i : truth.dead)
        isDead[static_cast<std::size_t>(i)] = true;
    std::complex<double> common = 0.0;
    std::vector<double> gains;
    const auto errorOf = [&](Eigen::Index i)
    { return std::polar(1.0, fit.array.phaseOffset_rad[i] - truth.phaseOffset_rad[i]); };
    const auto counts = [&](Eigen::Index i)
    { return !isDead[static_cast<std::size_t>(i)] && fit.array.gain[i] > 0.0; };
    for (Eigen::Index i = 0; i < truth.size(); ++i)
        if (counts(i))
        {
            common += errorOf(i);
            gains.push_back(truth.gain[i]);
        }
    const double median = base::percentile(gains, 0.5);
    double squares = 0.0, gainSquares = 0.0;
    for (Eigen::Index i = 0; i < truth.size(); ++i)
    {
        const bool foundDead = fit.states[static_cast<std::size_t>(i)] == TransducerState::DEAD;
        if (isDead[static_cast<std::size_t>(i)])
        {
            ++accuracy.dead;
            accuracy.deadFound += foundDead ? 1 : 0;
        }
        else if (foundDead)
            ++accuracy.deadWrong;
        if (!counts(i)) continue;
        const double error = std::arg(errorOf(i) * std::conj(common));
        if (std::abs(error) > 0.5 * base::kPi) ++accuracy.reversedWrong;
        squares += error * error;
        gainSquares += std::pow(fit.array.gain[i] - truth.gain[i] / median, 2.0);
    }
    const double count = std::max<double>(1.0, double(gains.size()));
    accuracy.phaseError_rad = std::sqrt(squares / count);
    accuracy.gainError = std::sqrt(gainSquares / count);
    accuracy.placeErrors_m = fit.microphone.places - hidden.places();
    const Eigen::Vector3d middle = hidden.places().col(0);
    accuracy.focus = focusOf(fit, truth, middle);
    for (int axis = 0; axis < 3; ++axis)
        accuracy.focus = std::min(
            accuracy.focus, focusOf(fit, truth, middle + kBeside_m * Eigen::Vector3d::Unit(axis)));
    return accuracy;
}

} // namespace midair::haptics
