#pragma once

#include "haptics/array/TransducerArray.h"
#include "haptics/tuning/TuningResponses.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::haptics
{

/// The phases that a microphone at one unknown place heard.
struct HeardPhases
{
    Eigen::Matrix3Xd positions; ///< 3 x n, of the transducers, metres
    Eigen::VectorXd phase_rad;  ///< n, arg y
    double wavenumber = 0.0;    ///< k, rad/m
};

/// A place, how well the doubled phases agree there, and the phase that they agree on.
struct FoundPlace
{
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    /// |mean of e^{2j (arg y + k R)}|, 0 .. 1: of a spread s e^{-2 s^2}
    double agreement = 0.0;
    double phase_rad = 0.0; ///< half the argument of that mean
    int starts = 0;         ///< that were tried
};

/// Returns \a angle less the nearest multiple of pi: -pi/2 .. pi/2.
double wrappedToHalfTurn(double angle_rad);

/// Finds the place within \a search_m of \a planned where the doubled phases agree best.
FoundPlace findPlace(const HeardPhases& heard, const Eigen::Vector3d& planned, double search_m);

/// What is known of the microphone and the air before.
struct MicrophonePrior
{
    double search_m = 6e-3;      ///< 0 .. 0.05: the farthest that it may be off its planned place
    double temperature_C = 20.0; ///< of the air
    double temperatureError_C = 2.0; ///< >= 0, its standard error
};

/// Where the microphone was, as the phases themselves say, and how the transducers then stand.
struct MicrophoneFit
{
    Eigen::Matrix3Xd places;                              ///< 3 x P, metres, array frame
    Eigen::Matrix3Xd placeErrors;                         ///< 3 x P, standard errors
    Eigen::Vector3d shiftError = Eigen::Vector3d::Zero(); ///< of what all places have in common
    double soundSpeed_m_s = 0.0;
    double soundSpeedError_m_s = 0.0;
    Eigen::VectorXd phase_rad; ///< P: common phase of each place, polarity aside
    /// Standard deviation of the transducers' phases, polarity aside; 52 degrees is pure chance.
    double spread_rad = 0.0;
    /// Of the phases of one transducer between places: reflections and noise; of one place it can't
    /// be told from the spread, and is 0.
    double scatter_rad = 0.0;
    std::string refusal; ///< why there is no fit, a sentence; empty: there is
};

/// Finds the places and the speed of sound at which the doubled phases of \a responses have the
/// least spread, so that a reversed transducer counts as any other:
///     rho_pi = arg y_pi + k |r_p - r_i| - gamma_p - phi_i  (mod pi),  phi_i ~ N(0, s^2).
/// \a live: m, which transducers count. A grid of starts a fifth of a doubled wavelength apart, the
/// best refined by robust least squares (Tukey's biweight); then all places and the speed of sound
/// together. Refuses a place whose spread exceeds 45 degrees, or that chance would explain.
MicrophoneFit fitMicrophone(const TransducerArray& array,
                            const Eigen::Matrix3Xd& planned,
                            const TuningResponses& responses,
                            const std::vector<bool>& live,
                            const MicrophonePrior& prior);

} // namespace midair::haptics
