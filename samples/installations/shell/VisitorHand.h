#pragma once

#include <osgMidair/HandSource>

#include <osg/Quat>
#include <osg/Vec3d>

namespace midair::samples
{

/// Returns the flat hand of a visitor who stands at the screen's side, -y, with the tip of its
/// index finger at \a tip; it is inclined by \a down_rad, fingers down. Positions in m.
osgMidair::Hand reachingHand(const osg::Vec3d& tip, double down_rad = 0.0);

/// The same with the index finger alone stretched: of the other fingers the tracker sees nothing
/// beyond the knuckles.
osgMidair::Hand pointingHand(const osg::Vec3d& tip, double down_rad = 0.0);

/// Goes from 0 to 1 while \a t goes from \a from to \a to, at rest at both ends.
double eased(double t, double from, double to);

} // namespace midair::samples
