#pragma once

#include "device/drive/DriveSignal.h"

#include <complex>
#include <vector>

namespace midair::device
{

/// Rounds activations to the nearest phase and duty level; |q| > 1 is clipped. A value that is not
/// finite silences the whole field (all duties 0) and gives false. \a q has m entries; \a signal is
/// resized.
bool encode(const std::complex<float>* q, int m, DriveSignal& signal);

/// What the hardware makes of a drive signal: e^{+j 2 pi phase/256} base::dutyAmplitude(duty).
void decode(const DriveSignal& signal, std::vector<std::complex<float>>& q);

/// The 256 relative amplitudes base::dutyAmplitude(L), ascending, for the solver to know.
const std::vector<float>& amplitudeLevels();

} // namespace midair::device
