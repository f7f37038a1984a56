#pragma once

#include "device/drive/DriveSequence.h"
#include "haptics/sequence/Modulator.h"

#include <cstdint>
#include <vector>

namespace midair::bridge
{

/// What is to be sent in step \a step (>= 0; at step/fieldRate_Hz) of a modulated \a cycle of at
/// least one signal. \a out is replaced.
void signalOfStep(const std::vector<device::DriveSignal>& cycle,
                  const haptics::Modulator& modulator,
                  std::int64_t step,
                  device::DriveSignal& out);

/// All steps of a modulated \a cycle until they repeat, for a device that times them by itself; no
/// signals where they don't repeat within \a most steps: the cycle is longer, or its amplitude
/// modulation's period is no whole number of steps.
device::DriveSequence sequenceOfSteps(const std::vector<device::DriveSignal>& cycle,
                                      const haptics::Modulator& modulator,
                                      int most);

} // namespace midair::bridge
