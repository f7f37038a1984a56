#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/scattering/ClosedBody.h"

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// What a rigid body in the field does to it.
struct ScatteringFigures
{
    Eigen::Index elements = 0;
    int iterations = 0;    ///< the most that a field took
    double residual = 0.0; ///< the largest, relative; above RigidBody::kResidual: not solved
    /// Of |p| with the body over |p| without it, minus 1, at the points of all fields.
    double rms = 0.0;
    double worst = 0.0; ///< largest magnitude of that
    double level = 1.0; ///< root mean square of |p| with the body over that without it
    std::vector<Eigen::VectorXcd> withBody_Pa; ///< of each field at its points
};

/// Returns what \a body does to \a fields (m activations each) at \a points (3 x n of each field,
/// metres; none may be empty). \a body, from RigidBody::divided(), is in the array frame, metres.
/// Throws base::InputError for points or transducers inside it, Stopped if \a stop requests it.
ScatteringFigures scatteringOf(const ClosedBody& body,
                               const std::vector<Eigen::Matrix3Xd>& points,
                               const std::vector<Eigen::VectorXcf>& fields,
                               const TransducerArray& array,
                               const Medium& medium,
                               int threads = 1,
                               const base::StopToken& stop = {});

} // namespace midair::haptics
