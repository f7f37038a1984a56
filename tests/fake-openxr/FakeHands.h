#pragma once

#include "engine-bridge/hands/Hand.h"
#include "tests/fake-openxr/FakeRuntime.h"

#include <cstdlib>

/// The fake runtime, as it comes, is the machine's OpenXR runtime from here on.
inline void useFakeRuntime()
{
    setenv("XR_RUNTIME_JSON", MIDAIR_FAKE_OPENXR, 1);
    FakeAccess state;
    *state = {};
}

/// \a hand (positions in OpenXR's space) as a runtime tells it.
inline FakeHand fakeHand(const midair::bridge::Hand& hand)
{
    FakeHand fake{};
    for (std::size_t i = 0; i < fake.size(); ++i)
    {
        const midair::bridge::HandJoint& joint = hand.joints[i];
        const Eigen::Vector3f p = joint.position.cast<float>();
        const Eigen::Quaternionf q = joint.orientation.cast<float>();
        fake[i].pose = {{q.x(), q.y(), q.z(), q.w()}, {p.x(), p.y(), p.z()}};
        fake[i].radius = static_cast<float>(joint.radius_m);
        if (joint.positionValid) fake[i].locationFlags |= XR_SPACE_LOCATION_POSITION_VALID_BIT;
        if (joint.orientationValid)
            fake[i].locationFlags |= XR_SPACE_LOCATION_ORIENTATION_VALID_BIT;
    }
    return fake;
}
