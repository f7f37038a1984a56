#include "engine-bridge/hands/openxr/OpenXrHandSource.h"

#include "engine-bridge/hands/openxr/OpenXrLending.h"

namespace midair::bridge
{

Eigen::Isometry3d OpenXrHandSource::upright()
{
    Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
    turn.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    return turn;
}

OpenXrHandSource::OpenXrHandSource(const OpenXrOptions& options,
                                   const Eigen::Isometry3d& placement) :
    _tracker(OpenXrTracker::open(options)),
    _asker(_tracker->newAsker(false)),
    _placement(placement)
{
}

bool OpenXrHandSource::frameAt(double time_s, HandFrame& frame)
{
    frame.time_s = time_s;
    if (!_tracker->latest(*_asker, frame)) return false;
    frame = transformed(frame, _placement);
    return true;
}

bool OpenXrHandSource::setHorizon(double ahead_s)
{
    OpenXrTracker::setHorizon(*_asker, ahead_s);
    return true;
}

bool OpenXrHandSource::shownFrame(HandFrame& frame)
{
    if (!OpenXrLending::one().shown(frame)) return false;
    frame = transformed(frame, _placement);
    return true;
}

} // namespace midair::bridge
