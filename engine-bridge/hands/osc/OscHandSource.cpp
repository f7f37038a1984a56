#include "engine-bridge/hands/osc/OscHandSource.h"

#include "haptics/base/threads/SteadyClock.h"

namespace midair::bridge
{

OscHandSource::OscHandSource(const OscOptions& options, const Eigen::Isometry3d& placement) :
    _receiver(OscReceiver::open(options)),
    _placement(placement)
{
}

bool OscHandSource::frameAt(double time_s, HandFrame& frame)
{
    frame.time_s = time_s;
    if (!_receiver->inbox().latest(base::steadySeconds(), frame)) return false;
    frame = transformed(frame, _placement);
    return true;
}

} // namespace midair::bridge
