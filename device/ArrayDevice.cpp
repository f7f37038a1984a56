#include "device/ArrayDevice.h"

#include "device/JointCommit.h"
#include "device/drive/DriveEncoder.h"

namespace midair::device
{

bool ArrayDevice::sendTogether(const DriveSignal& signal, const std::shared_ptr<JointCommit>& joint)
{
    const bool taken = send(signal);
    if (joint != nullptr) joint->leave();
    return taken;
}

std::vector<std::complex<float>> ArrayDevice::wouldPlay(const DriveSignal& signal) const
{
    std::vector<std::complex<float>> q;
    decode(signal, q);
    return q;
}

} // namespace midair::device
