#include "samples/installations/shell/VisitorHand.h"

#include <algorithm>

namespace midair::samples
{

namespace
{

// Joints in the order of OpenXR, from the one behind the knuckle on.
constexpr int kThumbProximal = 3;
constexpr int kThumbTip = 5;
constexpr int kMiddleIntermediate = 13;
constexpr int kLittleTip = 25;
constexpr int kFinger = 5; ///< joints of a finger

} // namespace

osgMidair::Hand reachingHand(const osg::Vec3d& tip, double down_rad)
{
    return osgMidair::openHand(1, tip, osg::Quat(osg::PI_2 - down_rad, osg::X_AXIS));
}

osgMidair::Hand pointingHand(const osg::Vec3d& tip, double down_rad)
{
    osgMidair::Hand hand = reachingHand(tip, down_rad);
    const auto hide = [&](int joint)
    { hand.joints[static_cast<std::size_t>(joint)].positionValid = false; };
    for (int joint = kThumbProximal; joint <= kThumbTip; ++joint)
        hide(joint);
    for (int first = kMiddleIntermediate; first <= kLittleTip; first += kFinger)
        for (int joint = first; joint < first + 3; ++joint)
            hide(joint);
    return hand;
}

double eased(double t, double from, double to)
{
    const double s = std::clamp((t - from) / (to - from), 0.0, 1.0);
    return s * s * (3.0 - 2.0 * s);
}

} // namespace midair::samples
