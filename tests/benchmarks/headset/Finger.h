#pragma once

#include "tests/fake-openxr/FakeHands.h"

#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <osg/MatrixTransform>
#include <osg/ShapeDrawable>

#include <string>

namespace midair::bench
{

/// The middle of a fingertip's ball, 1.5 mm deep in a surface at \a top_m.
inline double tipOver(double top_m)
{
    return top_m + 7.5e-3 - 1.5e-3;
}

/// From here on the tests' OpenXR runtime tracks the end of an index finger that points down on a
/// surface at \a top_m, and sways along x with \a speed.
inline void setFinger(double top_m, double speed)
{
    bridge::Hand hand = bridge::openHandWithIndexTipAt(
        1,
        Eigen::Vector3d(0.0, tipOver(top_m), 0.0),
        Eigen::Quaterniond(Eigen::AngleAxisd(-1.5707963267948966, Eigen::Vector3d::UnitX())));
    for (std::size_t i = 0; i < hand.joints.size(); ++i)
        hand.joints[i].positionValid = i == bridge::INDEX_DISTAL || i == bridge::INDEX_TIP;
    const FakeAccess fake;
    fake->hands[1] = fakeHand(hand);
    fake->speed = {static_cast<float>(speed), 0.0F, 0.0F};
    fake->start = FakeState::now();
}

/// A block of 130 x 60 x 10 mm whose upper side is at \a top_m.
inline osg::ref_ptr<osg::Node> block(double top_m)
{
    return new osg::ShapeDrawable(
        new osg::Box(osg::Vec3(0.0F, 0.0F, static_cast<float>(top_m - 5e-3)), 0.13F, 0.06F, 0.01F));
}

inline double topIn(const std::string& array)
{
    return array == "board" ? 0.15 : 0.0;
}

} // namespace midair::bench
