#include "engine-bridge/playing/SequenceOfSteps.h"

#include "device/drive/DriveEncoder.h"

#include <cmath>
#include <numeric>

namespace midair::bridge
{

namespace
{

// Relative tolerance for a whole number of steps: a modulation that is off by this share of a
// period each period drifts by one period in 10^9 of them, which takes days.
constexpr double kWhole = 1e-9;

// Steps per period of the amplitude modulation, 1 without one; 0 if that is not a whole number or
// more than most.
std::int64_t stepsOfModulation(const haptics::ModulatorOptions& options, int most)
{
    if (options.amplitudeRate_Hz <= 0.0) return 1;
    const double exact = options.fieldRate_Hz / options.amplitudeRate_Hz;
    const double steps = std::round(exact);
    if (steps < 1.0 || steps > most || std::abs(exact - steps) > kWhole * steps) return 0;
    return static_cast<std::int64_t>(steps);
}

} // namespace

void signalOfStep(const std::vector<device::DriveSignal>& cycle,
                  const haptics::Modulator& modulator,
                  std::int64_t step,
                  device::DriveSignal& out)
{
    const double time_s = static_cast<double>(step) * (1.0 / modulator.options().fieldRate_Hz);
    const haptics::Modulator::Step played = modulator.at(time_s, static_cast<int>(cycle.size()));
    device::scaleDuties(cycle[static_cast<std::size_t>(played.field)], played.amplitude, out);
}

device::DriveSequence sequenceOfSteps(const std::vector<device::DriveSignal>& cycle,
                                      const haptics::Modulator& modulator,
                                      int most)
{
    device::DriveSequence sequence;
    sequence.rate_Hz = modulator.options().fieldRate_Hz;
    const std::int64_t modulation = stepsOfModulation(modulator.options(), most);
    const auto fields = static_cast<std::int64_t>(cycle.size());
    if (modulation == 0 || fields == 0 || fields > most) return sequence;
    const std::int64_t steps = std::lcm(modulation, fields);
    if (steps > most) return sequence;
    sequence.signals.resize(static_cast<std::size_t>(steps));
    for (std::int64_t step = 0; step < steps; ++step)
        signalOfStep(cycle, modulator, step, sequence.signals[static_cast<std::size_t>(step)]);
    return sequence;
}

} // namespace midair::bridge
