#include "engine-bridge/HapticObject.h"

namespace midair::bridge
{

bool operator==(const HapticProperties& a, const HapticProperties& b)
{
    return a.pressure == b.pressure && a.pressureInPa == b.pressureInPa &&
           a.spacing_m == b.spacing_m && a.sampling == b.sampling && a.side == b.side &&
           a.priority == b.priority && a.modulationFrequency_Hz == b.modulationFrequency_Hz &&
           a.modulationDepth == b.modulationDepth;
}

} // namespace midair::bridge
