#pragma once

#include "haptics/scattering/RoundBody.h"

#include <Eigen/Core>

#include <vector>

namespace midair::bridge
{

/// The kit's open right hand (openHand()) as a body in the field, in its palm's frame, metres: the
/// fingers point to -z, the back to y.
struct RoundHand
{
    /// The bones from the palm on, without the wrist, and the flesh between the knuckles, without
    /// which the palm has grooves.
    std::vector<haptics::RoundCone> cones;
    Eigen::Vector3d indexTip = Eigen::Vector3d::Zero(); ///< centre of the fingertip's ball
    double indexRadius_m = 0.0;                         ///< of that
};

/// Returns it, an adult's.
RoundHand roundHand();

} // namespace midair::bridge
