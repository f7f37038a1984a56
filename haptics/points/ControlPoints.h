#pragma once

#include "haptics/surface/SurfaceSampler.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <functional>
#include <vector>

namespace midair::haptics
{

/// Points where pressure is wanted, in the array frame; n points, all members of the same length.
struct ControlPoints
{
    Eigen::Matrix3Xd positions; ///< 3 x n, metres
    Eigen::Matrix3Xd normals;   ///< 3 x n, unit length, pointing out of the object
    /// n, >= 0: wanted peak pressure; 0: the point is left out.
    Eigen::VectorXd targets;
    /// True: targets are in Pa. False: only their ratios count, and the array plays as loud as it
    /// can while it stays accurate.
    bool absolute = false;
    std::vector<int> object; ///< n or empty: index of the object each point belongs to
    /// n or empty: the same number in each update for the same place of the same object, so that a
    /// solver goes on where points come and go.
    std::vector<std::uint64_t> identity;

    int size() const { return static_cast<int>(positions.cols()); }
};

/// The points with the indices \a chosen, in that order.
ControlPoints pick(const ControlPoints& points, const std::vector<int>& chosen);

/// Appends \a more to \a to. Missing normals of one of them become zeros; objects and identities
/// are kept only if both have them. `absolute` is that of the one that has points.
void append(ControlPoints& to, const ControlPoints& more);

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
