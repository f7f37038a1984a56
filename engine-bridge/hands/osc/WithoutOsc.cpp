// Replaces OscHands.cpp in builds without oscpack: reports that OSC is not available.

#include "engine-bridge/hands/osc/OscHands.h"
#include "haptics/base/InputError.h"

namespace midair::bridge
{

void requireOsc()
{
    throw base::InputError("OSC is not in this build; configure it with -DMIDAIR_OSC=ON");
}

OscContent decodeOsc(const char*, std::size_t)
{
    requireOsc();
    return {};
}

std::size_t OscWriter::hands(const std::vector<Hand>&, double)
{
    requireOsc();
    return 0;
}

std::size_t OscWriter::head(const Head&)
{
    requireOsc();
    return 0;
}

std::size_t OscWriter::text(const std::string&)
{
    requireOsc();
    return 0;
}

std::size_t OscWriter::horizon(double)
{
    requireOsc();
    return 0;
}

} // namespace midair::bridge
