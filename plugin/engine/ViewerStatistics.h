#pragma once

#include <osgViewer/ViewerBase>

namespace osgMidair
{

class HapticEngine;

/// Writes a haptic scene's figures into a viewer's statistics, and has the viewer's `s` display
/// show them.
class ViewerStatistics
{
public:
    /// For frame \a frame; costs nothing while the viewer collects no statistics.
    void show(osgViewer::ViewerBase& viewer,
              const osgViewer::ViewerBase::Views& views,
              const HapticEngine& engine,
              unsigned int frame);

    bool collecting() const { return _collecting; }

private:
    void addLines(const osgViewer::ViewerBase::Views& views);

    bool _linesAdded = false;
    bool _collecting = false;
};

} // namespace osgMidair
