#pragma once

#include "haptics/scattering/ScatteredField.h"

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// What rigid things in the field do to it.
struct ScatteringFigures
{
    Eigen::Index elements = 0;
    int iterations = 0;    ///< the most that a field took
    double residual = 0.0; ///< the largest, relative; above RigidBody::kResidual: not solved
    /// Of |p| with the things over |p| without them, minus 1, at the points of all fields.
    double rms = 0.0;
    double worst = 0.0; ///< largest magnitude of that
    double level = 1.0; ///< root mean square of |p| with the things over that without them
    std::vector<Eigen::VectorXcd> free_Pa; ///< of each field at its points, without the things
    std::vector<Eigen::VectorXcd> with_Pa; ///< with them
};

/// Returns what the things of \a truth do to \a fields (m activations each) at \a points (3 x n of
/// each field, metres; none may be empty). Throws base::InputError for points inside one, Stopped.
ScatteringFigures scatteringOf(ScatteredField& truth,
                               const std::vector<Eigen::Matrix3Xd>& points,
                               const std::vector<Eigen::VectorXcf>& fields);

} // namespace midair::haptics
