#pragma once

#include <osgMidair/HapticField>
#include <osgMidair/HapticSettings>
#include <osgMidair/HapticStatistics>

#include <string>

namespace osgMidair
{

/// Returns the statistics of a scene as a JSON object, with the objects and control points of \a
/// field, its newest; null: there is none.
std::string reportJson(const HapticStatistics& statistics,
                       const HapticSettings& settings,
                       const HapticField* field = nullptr);

/// What the report has of a scene.
struct ReportedScene
{
    HapticStatistics statistics;
    HapticSettings settings;
    osg::ref_ptr<const HapticField> field; ///< the newest; may be null
};

/// Returns true if OSG_MIDAIR_REPORT names a file and the scene with the key \a scene was not kept
/// in the last second.
bool isReportDue(const void* scene);

/// Puts a scene as it is now into the file named by OSG_MIDAIR_REPORT, on a thread of its own: a
/// program that a signal ends runs no destructors, and leaves the report of its last second. The
/// file is replaced as a whole, never half written.
void keepReport(const void* scene, ReportedScene now);

/// Adds a scene that has ended to that file, which holds {"scenes": [..]} with all scenes of this
/// process so far. Does nothing if no file is named; warns if it can't be written.
void writeReport(const void* scene, const ReportedScene& last);

/// From now on the lines that devices log come to tellDeviceLines() and not to the standard output.
/// To be called before a device is opened; only the first call does something. Any thread.
void collectDeviceLines();

/// Passes what devices have logged since the last call on to osg::notify(). Devices log from their
/// own threads, and osg::notify() is for one: to be called by the update thread.
void tellDeviceLines();

} // namespace osgMidair
