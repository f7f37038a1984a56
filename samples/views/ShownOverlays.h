#pragma once

#include <osgMidair/HapticOverlays>

#include <algorithm>
#include <string>
#include <vector>

namespace midair::samples
{

/// Shows those of \a overlays that \a words name, and hides the others; none are named: all stay.
inline void showOverlays(osgMidair::HapticOverlays& overlays, const std::vector<std::string>& words)
{
    if (words.empty()) return;
    for (const osgMidair::OverlayDescription& overlay : osgMidair::HapticOverlays::describe())
        overlays.getOverlay(overlay.name)
            ->setShown(std::count(words.begin(), words.end(), overlay.word) > 0);
}

} // namespace midair::samples
