#pragma once

#include <osgMidair/DisplayView>

#include <osgViewer/View>

#include <cstdio>
#include <stdexcept>
#include <string>

#include <CLI/CLI.hpp>

namespace midair::samples
{

/// Adds the display that a window fills.
inline void addDisplay(CLI::App& app, std::string& display)
{
    app.add_option("--display",
                   display,
                   "Screen in the room that the window fills, seen by half mirrors or plates: "
                   "FILE.display.json; sim:FILE.display.json: what an eye would see of it")
        ->type_name("FILE");
}

/// Opens \a display; null for an empty text. Throws std::runtime_error.
inline osg::ref_ptr<osgMidair::DisplayView> openDisplay(const std::string& display)
{
    if (display.empty()) return nullptr;
    std::string error;
    const osg::ref_ptr<osgMidair::DisplayView> opened =
        osgMidair::DisplayView::open(display, error);
    if (!opened) throw std::runtime_error("--display: " + error);
    return opened;
}

/// Has \a display, which may be null, set \a view up. Throws std::runtime_error.
inline void showOn(osgMidair::DisplayView* display, osgViewer::View& view)
{
    std::string error;
    if (display && !display->attach(view, error)) throw std::runtime_error("--display: " + error);
}

} // namespace midair::samples
