#pragma once

#include "samples/tools/sense/SenseFiles.h"

#include <string>
#include <vector>

namespace midair::samples
{

/// Draws path, intensity and spectrum of samples, at equal intervals, into \a path (.png, .svg,
/// .pdf). Returns an error message, or an empty text.
std::string drawSensation(const std::string& path,
                          const std::string& title,
                          const std::vector<TimedSample>& samples);

} // namespace midair::samples
