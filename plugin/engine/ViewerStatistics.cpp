#include "plugin/engine/ViewerStatistics.h"

#include "plugin/engine/HapticEngine.h"

#include <osgViewer/View>
#include <osgViewer/ViewerEventHandlers>

namespace osgMidair
{

namespace
{

struct Line
{
    const char* label;
    const char* attribute;
    double HapticStatistics::*value;
    float multiplier;
};

constexpr Line kLines[] = {
    {"Haptic collect ms", "Haptic collect", &HapticStatistics::collect_ms, 1.0f},
    {"Haptic solve ms", "Haptic solve", &HapticStatistics::solve_ms, 1.0f},
    {"Haptic updates/s", "Haptic updates", &HapticStatistics::updatesPerSecond, 1.0f},
    {"Haptic rms %", "Haptic rms", &HapticStatistics::rms, 100.0f},
    {"Haptic latency ms", "Haptic latency", &HapticStatistics::latency_ms, 1.0f}};

} // namespace

void ViewerStatistics::addLines(const osgViewer::ViewerBase::Views& views)
{
    _linesAdded = true;
    const osg::Vec4 color(0.6f, 1.0f, 0.8f, 1.0f);
    for (osgViewer::View* view : views)
        for (const auto& handler : view->getEventHandlers())
        {
            auto* display = dynamic_cast<osgViewer::StatsHandler*>(handler.get());
            if (!display) continue;
            for (const Line& line : kLines)
                display->addUserStatsLine(line.label,
                                          color,
                                          color,
                                          line.attribute,
                                          line.multiplier,
                                          false,
                                          false,
                                          "",
                                          "",
                                          0.0f);
        }
}

void ViewerStatistics::show(osgViewer::ViewerBase& viewer,
                            const osgViewer::ViewerBase::Views& views,
                            const HapticEngine& engine,
                            unsigned int frame)
{
    // The display reads the lines when it is first switched on, so they have to be added before.
    if (!_linesAdded) addLines(views);
    osg::Stats* stats = viewer.getViewerStats();
    _collecting = stats && stats->collectStats("frame_rate");
    if (!_collecting) return;
    const HapticStatistics now = engine.statistics();
    for (const Line& line : kLines)
        stats->setAttribute(frame, line.attribute, now.*line.value);
}

} // namespace osgMidair
