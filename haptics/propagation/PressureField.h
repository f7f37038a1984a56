#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/StopToken.h"

#include <Eigen/Core>

namespace midair::haptics
{

/// A rectangle in the array frame, sampled at columns x rows points from its corner along u and v;
/// the outer points lie on its edges (on the corner where there is only one).
struct FieldGrid
{
    Eigen::Vector3d corner; ///< metres
    Eigen::Vector3d u;      ///< metres, the whole edge along the columns
    Eigen::Vector3d v;      ///< metres, the whole edge along the rows
    int columns = 0;
    int rows = 0;

    Eigen::Matrix3Xd points() const; ///< 3 x (columns * rows), row by row
};

/// Complex peak pressure in Pa at \a points (3 x n) for \a activations (m, |q| = 1 is full drive);
/// on \a threads threads. Transducers with an activation of 0 cost nothing. To 1e-5 of what all of
/// them in phase would give there. Throws InputError where the activations are not as many as the
/// transducers, Stopped where \a stop asks for it.
Eigen::VectorXcf pressureAt(const Eigen::Matrix3Xd& points,
                            const TransducerArray& array,
                            const Medium& medium,
                            const Eigen::VectorXcf& activations,
                            int threads = 1,
                            const base::StopToken& stop = {});

/// Time-averaged pressure on a surface, Pa: alpha p_rms^2 / (rho c^2), 1 <= alpha <= 2 (Inoue,
/// Makino, Shinoda 2015, equation 1, per area); \a pressure_Pa is a peak amplitude. alpha is 2
/// where the surface reflects all, as skin nearly does.
double radiationPressure(double pressure_Pa, const Medium& medium, double alpha = 2.0);

/// N: radiationPressure over \a area_m2, on which the pressure is the same everywhere.
double radiationForce(double pressure_Pa, double area_m2, const Medium& medium, double alpha = 2.0);

} // namespace midair::haptics
