#pragma once

#include "haptics/tuning/TuningFit.h"

#include <string>

namespace midair::samples
{

/// Draws the picture of a fit into \a path (.svg, .png, .pdf): a map of the array, each side seen
/// from where it emits to, with the phases of its transducers, the reversed and the dead ones, and
/// the histograms of phases and gains. Returns what went wrong, or an empty text.
std::string drawTuning(const haptics::TuningFit& fit, const std::string& path);

} // namespace midair::samples
