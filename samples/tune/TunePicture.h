#pragma once

#include "haptics/tuning/TuningFit.h"

#include <string>

namespace midair::samples
{

/// Returns the picture of a fit as SVG: a map of the array, each side seen from where it emits to,
/// with the phases of its transducers, the reversed and the dead ones, and the histograms of phases
/// and gains.
std::string pictureOf(const haptics::TuningFit& fit);

} // namespace midair::samples
