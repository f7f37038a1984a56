#pragma once

#include "device/drive/DriveSignal.h"

#include <complex>
#include <vector>

namespace midair::device
{

/// Rounds activations to the nearest phase and duty levels; clips |q| > 1. \a q has m entries; \a
/// signal is resized. If a value is not finite, sets all duties to 0 and returns false.
bool encode(const std::complex<float>* q, int m, DriveSignal& signal);

/// Converts a drive signal to the hardware's activations: e^{+j 2 pi phase/256}
/// base::dutyAmplitude(duty).
void decode(const DriveSignal& signal, std::vector<std::complex<float>>& q);

/// The 256 relative amplitudes base::dutyAmplitude(L), ascending.
const std::vector<float>& amplitudeLevels();

/// Sets \a scaled to \a signal with all amplitudes multiplied by \a gain (0 .. 1) and rounded down
/// to duty levels, so that no limit is exceeded.
void scaleDuties(const DriveSignal& signal, double gain, DriveSignal& scaled);

} // namespace midair::device
