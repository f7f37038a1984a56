#pragma once

#include <osgMidair/HapticSettings>
#include <osgMidair/HapticStatistics>

#include <string>

namespace osgMidair
{

/// Returns the statistics of a scene as a JSON object.
std::string reportJson(const HapticStatistics& statistics, const HapticSettings& settings);

/// Adds a scene that has ended to the file named by OSG_MIDAIR_REPORT, which holds {"scenes": [..]}
/// with all scenes of this process so far. Does nothing if no file is named; warns if it can't be
/// written.
void writeReport(const HapticStatistics& statistics, const HapticSettings& settings);

} // namespace osgMidair
