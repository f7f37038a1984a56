#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"
#include "haptics/base/threads/StopToken.h"

#include <Eigen/Core>

#include <vector>

#include <fmt/format.h>

namespace midair::haptics
{

/// Throws InputError unless \a activations has one entry per transducer of \a array.
inline void checkActivations(const TransducerArray& array, const Eigen::VectorXcf& activations)
{
    if (activations.size() != array.size())
        throw base::InputError(fmt::format(
            "activations are {}; there must be one for each of the array's {} transducers",
            activations.size(),
            array.size()));
}

/// Rectangle in the array frame, sampled at columns x rows points from its corner along u and v.
/// The outer points lie on its edges (at the corner if there is only one).
struct FieldGrid
{
    Eigen::Vector3d corner; ///< metres
    Eigen::Vector3d u;      ///< metres, edge from the first column to the last
    Eigen::Vector3d v;      ///< metres, edge from the first row to the last
    int columns = 0;
    int rows = 0;

    Eigen::Matrix3Xd points() const; ///< 3 x (columns * rows), row by row
};

/// Returns the complex peak pressure in Pa at \a points (3 x n) for \a activations (m, |q| = 1 is
/// full drive), on \a threads threads. Transducers with an activation of 0 cost nothing. The error
/// is at most 1e-5 of the pressure of all transducers in phase. Throws InputError if there is not
/// one activation per transducer, Stopped if \a stop requests it.
Eigen::VectorXcf pressureAt(const Eigen::Matrix3Xd& points,
                            const TransducerArray& array,
                            const Medium& medium,
                            const Eigen::VectorXcf& activations,
                            int threads = 1,
                            const base::StopToken& stop = {});

/// The same for each of \a fields (K times m activations), n x K; computes each row of G once.
Eigen::MatrixXcf pressuresAt(const Eigen::Matrix3Xd& points,
                             const TransducerArray& array,
                             const Medium& medium,
                             const std::vector<Eigen::VectorXcf>& fields,
                             int threads = 1,
                             const base::StopToken& stop = {});

/// Returns |p|^2 in Pa^2 at \a points (3 x n), averaged over \a fields (>= 1 times m activations);
/// computes each row of G once. Throws as pressureAt() does, and InputError for no fields.
Eigen::VectorXd meanSquarePressure(const Eigen::Matrix3Xd& points,
                                   const TransducerArray& array,
                                   const Medium& medium,
                                   const std::vector<Eigen::VectorXcf>& fields,
                                   int threads = 1,
                                   const base::StopToken& stop = {});

/// Returns the time-averaged pressure on a surface, Pa: alpha p_rms^2 / (rho c^2), 1 <= alpha <= 2
/// (Inoue, Makino, Shinoda 2015, equation 1, per area). \a pressure_Pa is a peak amplitude. alpha
/// is 2 for total reflection, a good approximation for skin.
double radiationPressure(double pressure_Pa, const Medium& medium, double alpha = 2.0);

/// Returns the force in N: radiationPressure() times \a area_m2, for a uniform pressure.
double radiationForce(double pressure_Pa, double area_m2, const Medium& medium, double alpha = 2.0);

} // namespace midair::haptics
