#include "device/drive/DriveSignal.h"

#include <algorithm>

namespace midair::device
{

bool DriveSequence::fits(int transducers) const
{
    return !signals.empty() && rate_Hz > 0.0 && rate_Hz <= kMostRate_Hz &&
           std::all_of(signals.begin(),
                       signals.end(),
                       [&](const DriveSignal& signal) { return signal.fits(transducers); });
}

} // namespace midair::device
