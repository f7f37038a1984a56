#pragma once

#include <osgMidair/HapticField>
#include <osgMidair/HapticSettings>
#include <osgMidair/HapticStatistics>

#include <string>

namespace osgMidair
{

/// Returns the statistics of a scene as a JSON object, with the objects and control points of \a
/// field, its newest; null: none.
std::string reportJson(const HapticStatistics& statistics,
                       const HapticSettings& settings,
                       const HapticField* field = nullptr);

/// A scene's data for the report.
struct ReportedScene
{
    HapticStatistics statistics;
    HapticSettings settings;
    osg::ref_ptr<const HapticField> field; ///< the newest; may be null
};

/// Returns true if OSG_MIDAIR_REPORT is set and the scene with the key \a scene was not stored in
/// the last second.
bool isReportDue(const void* scene);

/// Stores a scene's present state in the file OSG_MIDAIR_REPORT, on a separate thread: a program
/// ended by a signal runs no destructors, and leaves the report of its last second. The file is
/// replaced as a whole, never half written.
void keepReport(const void* scene, ReportedScene now);

/// Adds a finished scene to that file, which holds {"scenes": [..]} with all scenes of this
/// process. Does nothing if no file is set; warns if writing fails.
void writeReport(const void* scene, const ReportedScene& last);

/// From now on lines logged by devices go to tellDeviceLines() instead of the standard output. Call
/// it before opening a device; only the first call counts. Any thread.
void collectDeviceLines();

/// Passes the lines that devices have logged since the last call to osg::notify(). Call it on the
/// update thread: devices log on their own threads, but osg::notify() is for one thread.
void tellDeviceLines();

} // namespace osgMidair
