#pragma once

#include "device/drive/DriveSignal.h"
#include "haptics/sequence/Modulator.h"

#include <cstdint>
#include <vector>

namespace midair::bridge
{

/// Replaces \a out by the signal for step \a step (>= 0; at step/fieldRate_Hz) of a modulated
/// \a cycle of at least one signal.
void signalOfStep(const std::vector<device::DriveSignal>& cycle,
                  const haptics::Modulator& modulator,
                  std::int64_t step,
                  device::DriveSignal& out);

/// All steps of one period of a modulated \a cycle, for a device that times them by itself. Has no
/// signals if the period is longer than \a most steps, or the period of the amplitude modulation is
/// not a whole number of steps.
device::DriveSequence sequenceOfSteps(const std::vector<device::DriveSignal>& cycle,
                                      const haptics::Modulator& modulator,
                                      int most);

} // namespace midair::bridge
