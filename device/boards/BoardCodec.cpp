#include "device/boards/BoardCodec.h"

#include "haptics/base/DutyLaw.h"
#include "haptics/base/Units.h"

#include <cmath>

namespace midair::device
{

int delaySteps(int phase, int steps)
{
    const int later = (256 - phase) * steps;
    return ((later + 128) / 256) % steps;
}

std::complex<float> pulseActivation(double delay_turns, double duty)
{
    return std::complex<float>(
        std::polar(base::pulseAmplitude(duty, 1), -base::kTwoPi * delay_turns));
}

double BoardCodec::fieldsPerSecond(int transducers) const
{
    std::vector<std::uint8_t> field;
    appendSilentField(field, transducers);
    return bytesPerSecond() / static_cast<double>(field.size());
}

void BoardCodec::appendSilentField(std::vector<std::uint8_t>& out, int transducers) const
{
    DriveSignal off;
    off.phase.assign(transducers, 0);
    off.duty.assign(transducers, 0);
    appendField(out, off);
}

void BoardCodec::appendSilence(std::vector<std::uint8_t>& out, int transducers) const
{
    appendOpening(out);
    for (int i = 0; i < silentFields(); ++i)
        appendSilentField(out, transducers);
}

} // namespace midair::device
