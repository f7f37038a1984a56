#pragma once

#include "engine-bridge/display/Display.h"

#include <osg/Group>
#include <osg/ref_ptr>
#include <osgViewer/Viewer>

#include <string>

namespace midair::samples
{

/// The picture on a display's screen while its place is measured: signs at pixels of the screen
/// itself, without correction for optics.
class ScreenSigns
{
public:
    explicit ScreenSigns(const bridge::Display& display);

    /// Shows the cross \a index of bridge::displayCrosses() large and the others dim.
    void showCross(int index);

    /// Shows bridge::shownTags() of the display in black and white. Throws base::InputError if the
    /// build has no AprilTag.
    void showTags();

    /// Opens a window that fills the screen \a number. Throws base::InputError without an X
    /// display.
    void openWindow(int number);
    /// Draws the window, if there is one. Returns false once it is closed.
    bool frame();

    /// Draws the signs off screen into a picture file. Throws base::InputError.
    void save(const std::string& path) const;

private:
    const bridge::Display _display;
    int _width, _height;
    osg::ref_ptr<osg::Group> _signs = new osg::Group;
    osg::ref_ptr<osgViewer::Viewer> _viewer;
};

} // namespace midair::samples
