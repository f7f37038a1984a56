#pragma once

#include "haptics/surface/SurfaceSampler.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <functional>
#include <vector>

namespace midair::haptics
{

/// Samples of one object in the array frame; all matrices and vectors have the same length.
struct PosedObject
{
    int object = 0;      ///< index for ControlPoints::object
    int priority = 0;    ///< where points compete, those of larger priority stay
    double target = 1.0; ///< > 0; multiplied by the intensity
    /// > 0; least distance of points of other objects (of two objects the larger one counts)
    double spacing_m = 8.5e-3;
    Eigen::Matrix3Xd positions;          ///< 3 x n, metres, array frame
    Eigen::Matrix3Xd normals;            ///< 3 x n
    Eigen::VectorXf intensity;           ///< n or empty: 1
    std::vector<std::uint64_t> identity; ///< n or empty, see ControlPoints::identity

    /// Fills positions, normals and intensity from \a samples; allocates only if their number
    /// changes. Sample i gets the identity \a first + i.
    void pose(const SurfaceSamples& samples,
              const Eigen::Isometry3d& meshToArray,
              std::uint64_t first = 0);
    /// Keeps the samples for which \a isKept(index) is true.
    void keepIf(const std::function<bool(Eigen::Index)>& isKept);
};

} // namespace midair::haptics
