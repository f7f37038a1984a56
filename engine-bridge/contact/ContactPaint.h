#pragma once

#include "engine-bridge/hands/MeshDistance.h"

#include <Eigen/Core>

#include <memory>

namespace midair::bridge
{

/// What is painted on an object where a contact is: a factor on the pressure, as for control
/// points. So an image of heights is felt as a finger goes over it, as fast as it goes.
///
/// Between two frames of hands the place goes on in a straight line to the newest one, so that the
/// course has no steps at the rate of frames; it is late by one frame.
class ContactPaint
{
public:
    /// The contact is at \a place (m, mesh frame) of \a mesh, which may be null, at \a time_s. The
    /// first time, or on another mesh's triangles, it is there at once.
    void
    follow(std::shared_ptr<const MeshDistance> mesh, const Eigen::Vector3d& place, double time_s);
    void advance(double dt_s); ///< finite, >= 0

    double intensity() const { return _intensity; } ///< 0 .. 1; 1 where nothing is painted

private:
    void look();

    std::shared_ptr<const MeshDistance> _mesh; ///< null: nothing is painted on it
    Eigen::Vector3d _place = Eigen::Vector3d::Zero();
    Eigen::Vector3d _target = Eigen::Vector3d::Zero();
    double _left_s = 0.0; ///< until it is there
    double _time_s = 0.0; ///< of the last follow()
    double _intensity = 1.0;
};

} // namespace midair::bridge
