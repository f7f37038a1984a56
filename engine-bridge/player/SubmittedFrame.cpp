#include "engine-bridge/player/SubmittedFrame.h"

#include "engine-bridge/playing/EarWatch.h"

#include <algorithm>

namespace midair::bridge
{

namespace
{

bool sameObject(const HapticObject& a, const HapticObject& b)
{
    return a.id == b.id && a.meshId == b.meshId && a.properties == b.properties &&
           a.clips == b.clips && a.pose.matrix() == b.pose.matrix();
}

} // namespace

void SubmittedFrame::note(const SceneSnapshot& snapshot, double now_s)
{
    _objects = snapshot.objects;
    _around = snapshot.around;
    _ears = snapshot.ears;
    _at_s = now_s;
    _isAny = true;
}

bool SubmittedFrame::differs(const SceneSnapshot& snapshot, bool objectsToo) const
{
    if (!_isAny || !equivalent(snapshot.around, _around)) return true;
    const Eigen::Matrix3Xd& ears = snapshot.ears;
    if (ears.cols() != _ears.cols() ||
        (ears.cols() > 0 &&
         !((ears - _ears).colwise().norm().maxCoeff() <= EarWatch::kTolerance_m)))
        return true;
    return objectsToo && !std::equal(snapshot.objects.begin(),
                                     snapshot.objects.end(),
                                     _objects.begin(),
                                     _objects.end(),
                                     sameObject);
}

} // namespace midair::bridge
