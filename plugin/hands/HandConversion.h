#pragma once

#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/scene/Convert.h"

#include <osgMidair/HandSource>

namespace osgMidair
{

static_assert(Hand::kJoints == midair::bridge::HAND_JOINTS, "one order of joints for both");

inline Hand fromBridge(const midair::bridge::Hand& hand)
{
    Hand result;
    result.id = hand.id;
    result.age = hand.age_s;
    for (std::size_t i = 0; i < Hand::kJoints; ++i)
    {
        const midair::bridge::HandJoint& joint = hand.joints[i];
        const Eigen::Quaterniond& q = joint.orientation;
        result.joints[i] = {midair::bridge::toOsg(joint.position),
                            osg::Quat(q.x(), q.y(), q.z(), q.w()),
                            joint.radius_m,
                            joint.positionValid,
                            joint.orientationValid};
    }
    return result;
}

inline midair::bridge::Hand toBridge(const Hand& hand)
{
    midair::bridge::Hand result;
    result.id = hand.id;
    result.age_s = hand.age;
    for (std::size_t i = 0; i < Hand::kJoints; ++i)
    {
        const HandJoint& joint = hand.joints[i];
        const osg::Quat& q = joint.orientation;
        result.joints[i] = {midair::bridge::toEigen(joint.position),
                            Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()),
                            joint.radius,
                            joint.positionValid,
                            joint.orientationValid};
    }
    return result;
}

} // namespace osgMidair
