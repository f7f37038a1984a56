#pragma once

#include "engine-bridge/pipeline/SceneSnapshot.h"

#include <Eigen/Core>

#include <vector>

namespace midair::bridge
{

/// The frame that was handed over last, to find whether another one differs.
class SubmittedFrame
{
public:
    /// From now on every frame differs.
    void forget() { _isAny = false; }
    bool isAny() const { return _isAny; }

    /// Notes \a snapshot, which is about to be handed over at \a now_s (steady clock).
    void note(const SceneSnapshot& snapshot, double now_s);
    double since_s() const { return _at_s; }

    /// Returns true if \a snapshot differs. \a objectsToo: false compares only what is around the
    /// objects, where it is known that they are the same.
    bool differs(const SceneSnapshot& snapshot, bool objectsToo) const;

    bool hasObjects() const { return !_objects.empty(); }

private:
    std::vector<HapticObject> _objects;
    HandsAndObstacles _around;
    Eigen::Matrix3Xd _ears = Eigen::Matrix3Xd(3, 0);
    double _at_s = 0.0;
    bool _isAny = false;
};

} // namespace midair::bridge
