#pragma once

#include "haptics/array/TransducerArray.h"
#include "haptics/tuning/TuningResponses.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::haptics
{

/// Phases measured by a microphone at one unknown place.
struct HeardPhases
{
    Eigen::Matrix3Xd positions; ///< 3 x n, of the transducers, metres
    Eigen::VectorXd phase_rad;  ///< n, arg y
    double wavenumber = 0.0;    ///< k, rad/m
};

/// A place, the agreement of the doubled phases there, and their common phase.
struct FoundPlace
{
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    /// |mean of e^{2j (arg y + k R)}|, 0 .. 1: e^{-2 s^2} for a spread s
    double agreement = 0.0;
    double phase_rad = 0.0; ///< half the argument of that mean
    int starts = 0;         ///< number of tried starts
};

/// Returns \a angle less the nearest multiple of pi: -pi/2 .. pi/2.
double wrappedToHalfTurn(double angle_rad);

/// Finds the place within \a search_m of \a planned where the doubled phases agree best.
FoundPlace findPlace(const HeardPhases& heard, const Eigen::Vector3d& planned, double search_m);

/// Prior knowledge of the microphone and the air.
struct MicrophonePrior
{
    double search_m = 6e-3;          ///< 0 .. 0.05: largest distance from its planned place
    double temperature_C = 20.0;     ///< of the air
    double temperatureError_C = 2.0; ///< >= 0, its standard error
};

/// Microphone positions and transducer phases, fitted to the measured phases.
struct MicrophoneFit
{
    Eigen::Matrix3Xd places;                              ///< 3 x P, metres, array frame
    Eigen::Matrix3Xd placeErrors;                         ///< 3 x P, standard errors
    Eigen::Vector3d shiftError = Eigen::Vector3d::Zero(); ///< common to all places
    double soundSpeed_m_s = 0.0;
    double soundSpeedError_m_s = 0.0;
    Eigen::VectorXd phase_rad; ///< P: common phase of each place, polarity aside
    /// Standard deviation of the transducers' phases, ignoring polarity; 52 degrees is pure chance.
    double spread_rad = 0.0;
    /// Scatter of one transducer's phases between places: reflections and noise. For a single place
    /// it can't be separated from the spread, and is 0.
    double scatter_rad = 0.0;
    std::string refusal; ///< reason, a sentence, if there is no fit; otherwise empty
};

/// Finds the places and the speed of sound that minimise the spread of the doubled phases of \a
/// responses, so that reversed transducers count like others:
///     rho_pi = arg y_pi + k |r_p - r_i| - gamma_p - phi_i  (mod pi),  phi_i ~ N(0, s^2).
/// \a live: m, transducers to use. A grid of starts a fifth of a doubled wavelength apart, the best
/// refined by robust least squares (Tukey's biweight); then all places and the speed of sound
/// together. Refuses a place whose spread exceeds 45 degrees or could be chance.
MicrophoneFit fitMicrophone(const TransducerArray& array,
                            const Eigen::Matrix3Xd& planned,
                            const TuningResponses& responses,
                            const std::vector<bool>& live,
                            const MicrophonePrior& prior);

} // namespace midair::haptics
