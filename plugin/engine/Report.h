#pragma once

#include <osgMidair/HapticSettings>
#include <osgMidair/HapticStatistics>

#include <string>

namespace osgMidair
{

/// \a statistics of a scene as a JSON object.
std::string reportJson(const HapticStatistics& statistics, const HapticSettings& settings);

/// Adds a scene that has ended to the file that OSG_MIDAIR_REPORT names: {"scenes": [..]} with all
/// of this process so far. Does nothing when none is named; a file that can't be written is a
/// warning.
void writeReport(const HapticStatistics& statistics, const HapticSettings& settings);

} // namespace osgMidair
