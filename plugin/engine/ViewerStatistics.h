#pragma once

#include <osgViewer/ViewerBase>

namespace osgMidair
{

class HapticEngine;

/// Writes the figures of a haptic scene into a viewer's statistics and makes the viewer's `s`
/// display show them.
class ViewerStatistics
{
public:
    /// Writes the figures of frame \a frame; costs nothing while the viewer collects no statistics.
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
