#include "samples/installations/jnd/SimulatedParticipant.h"

#include "haptics/base/text/Range.h"

#include <cmath>
#include <random>

namespace midair::samples
{

namespace
{

double normalDistribution(double x)
{
    return 0.5 * std::erfc(-x / std::sqrt(2.0));
}

} // namespace

double SimulatedParticipant::chance(double value) const
{
    return 0.5 * lapse + (1.0 - lapse) * normalDistribution((value - threshold) / spread);
}

bool SimulatedParticipant::feels(int trial, double value) const
{
    // A generator for each trial: std::seed_seq spreads neighbouring seeds, and both are the same
    // with every standard library.
    std::seed_seq mix{static_cast<std::uint32_t>(seed),
                      static_cast<std::uint32_t>(seed >> 32U),
                      static_cast<std::uint32_t>(trial)};
    std::mt19937_64 random(mix);
    return static_cast<double>(random() >> 11U) * 0x1p-53 < chance(value);
}

std::string problemOf(const SimulatedParticipant& participant)
{
    std::string problem;
    base::RangeCheck("the simulated participant's ")
        .atLeast("threshold", participant.threshold, 0.0)
        .above("spread", participant.spread, 0.0)
        .within("lapse", participant.lapse, 0.0, 1.0)
        .passed(&problem);
    return problem;
}

} // namespace midair::samples
