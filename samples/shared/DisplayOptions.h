#pragma once

#include <osgMidair/DisplayView>
#include <osgMidair/HeadsetView>

#include <osgViewer/View>

#include <cstdio>
#include <stdexcept>
#include <string>

#include <CLI/CLI.hpp>

namespace midair::samples
{

/// Adds the option --display.
inline void addDisplay(CLI::App& app, std::string& display)
{
    app.add_option("--display",
                   display,
                   "Where to show the scene: FILE.display.json: on the screen behind a half mirror "
                   "or plate; sim:FILE.display.json: in a window, as an eye would see that screen; "
                   "openxr:: in a headset")
        ->type_name("FILE");
}

inline bool isHeadset(const std::string& display)
{
    return display.rfind("openxr:", 0) == 0;
}

/// Opens the headset that \a display names, prints its status and attaches it to \a view. Returns
/// null, after printing the reason, if there is none.
inline osg::ref_ptr<osgMidair::HeadsetView> showInHeadset(const std::string& display,
                                                          osgViewer::View& view)
{
    if (!isHeadset(display)) return nullptr;
    std::string error;
    osg::ref_ptr<osgMidair::HeadsetView> headset = osgMidair::HeadsetView::open(display, error);
    if (headset && !headset->attach(view, error)) headset = nullptr;
    std::fprintf(stderr,
                 "--display: %s\n",
                 headset ? headset->getStatus().c_str() : (error + "; using a window").c_str());
    return headset;
}

/// Opens \a display. Returns null for an empty text and for a headset. Throws std::runtime_error.
inline osg::ref_ptr<osgMidair::DisplayView> openDisplay(const std::string& display)
{
    if (display.empty() || isHeadset(display)) return nullptr;
    std::string error;
    const osg::ref_ptr<osgMidair::DisplayView> opened =
        osgMidair::DisplayView::open(display, error);
    if (!opened) throw std::runtime_error("--display: " + error);
    return opened;
}

/// Attaches \a display, which may be null, to \a view. Throws std::runtime_error.
inline void showOn(osgMidair::DisplayView* display, osgViewer::View& view)
{
    std::string error;
    if (display && !display->attach(view, error)) throw std::runtime_error("--display: " + error);
}

} // namespace midair::samples
