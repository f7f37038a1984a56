#pragma once

#include "engine-bridge/hands/Hand.h"

#include <Eigen/Core>

#include <vector>

namespace midair::tests
{

/// \{ A recording of a hand that never was: a right index finger feels the front of the demo's
/// star, which stands still in the middle.
constexpr double kStarRate_Hz = 90.0;
constexpr double kStarPeriod_s = 4.8; ///< the last frame is the first again
/// \}

/// The star of samples/models/star.obj as midair-demo --still places it: 3 x 30, the corners of its
/// front's ten triangles, three of each in turn; metres.
Eigen::Matrix3Xd starFront();

/// What the finger does at \a time_s (any): where it is above the front, and how far.
struct FingerPlace
{
    double x_m = 0.0;
    double z_m = 0.0;
    double gap_m = 0.0; ///< from the skin to the star; below 0: so deep is it in
    bool slides = false;
};
FingerPlace fingerAt(double time_s);

/// The frames of one period, rounded to 10 um and 1e-4 of a quaternion.
std::vector<bridge::HandFrame> starHand();

} // namespace midair::tests
