#pragma once

#include "haptics/array/TransducerArray.h"

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

struct SelectorOptions;

/// Tells which places an array can reach; made once for an array and a wavelength.
class Workspace
{
public:
    enum class Verdict
    {
        INSIDE,
        TOO_CLOSE,
        BEHIND, ///< every transducer faces away, or the board of the nearest one is in between
        OUT_OF_REACH
    };

    /// Throws InputError for an array without transducers, a wavelength that is not positive and
    /// options out of range.
    Workspace(const TransducerArray& array, double wavelength_m, const SelectorOptions& options);

    Verdict judge(const Eigen::Vector3d& point) const;
    double minDistance_m() const { return _minDistance; }
    double reach_m() const { return _reach; }
    double wavelength_m() const { return _wavelength; }

private:
    struct Plane
    {
        Eigen::Vector3d normal;
        double offset;
        Eigen::Vector3d sample; ///< one of its transducers
    };

    Eigen::Matrix3Xd _positions;
    Eigen::Matrix3Xd _normals;
    std::vector<Plane> _planes; ///< the distinct planes that transducers lie in
    double _wavelength;
    double _minDistance;
    double _reach = 0.0;
};

} // namespace midair::haptics
