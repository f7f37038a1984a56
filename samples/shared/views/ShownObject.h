#pragma once

#include "samples/shared/views/Offscreen.h"

#include <osgMidair/DisplayView>
#include <osgMidair/HapticOverlays>

#include <osg/Vec4>
#include <osgText/Font>

#include <functional>
#include <string>

namespace midair::samples
{

/// Returns the path of \a name ("models/star.obj") below the samples' folder: that of the installed
/// samples where the program is installed, else that of the sources.
std::string sampleFile(const std::string& name);

/// Returns the font of pictures and signs: DejaVu Sans (Debian: fonts-dejavu-core), else OSG's own.
osg::ref_ptr<osgText::Font> labelFont();

/// From now on this program opens `sim:?board=autd3` as well: AUTD3 units that are emulated in it.
void registerEmulatedDevices();

/// Behind all that is shown.
inline const osg::Vec4 kShownBackground(0.052F, 0.060F, 0.078F, 1.0F);

/// Model read by any OSG plugin, scaled to a size and centred, with materials that show its shape.
struct ShownObject
{
    std::string name;              ///< file name without folders
    osg::ref_ptr<osg::Node> model; ///< metres; the centre of its bounding box is at the origin
    osg::ref_ptr<osg::Node> edges; ///< outline and creases, drawn over the field; not felt
    osg::Vec3d extent_m;
    bool flat = false; ///< drawn transparent, because the field's slice is in its plane
};

/// Reads \a path and scales it to a largest extent of \a size_m (0: unchanged). \a isOpaque: what
/// is flat is drawn as all else. Throws std::runtime_error that names the file.
ShownObject loadShownObject(const std::string& path, double size_m, bool isOpaque = false);

/// Returns a group with two lights (key and fill) and \a scene below it.
osg::ref_ptr<osg::Group> lit(osg::Node* scene);

/// Takes still pictures of a scene that another viewer runs, at twice the size and averaged down.
class PictureTaker
{
public:
    /// \a aim sets view, projection and background of the camera. \a problem gets the reason if
    /// there is no OpenGL; take() then returns null.
    PictureTaker(osg::Node& scene,
                 osgMidair::HapticOverlays& overlays,
                 int width,
                 int height,
                 double fovy_deg,
                 const std::function<void(osg::Camera&)>& aim,
                 std::string& problem);

    /// Has \a display, which may be null, aim from now on. Throws std::runtime_error.
    void showOn(osgMidair::DisplayView* display);
    osg::ref_ptr<osg::Image> take();

private:
    static constexpr int kScale = 2;

    osg::ref_ptr<osgMidair::HapticOverlays> _overlays;
    osgViewer::Viewer _viewer;
    osg::ref_ptr<FrameGrabber> _grabber;
    osg::ref_ptr<osgMidair::DisplayView> _display;
    bool _ready = false;
};

} // namespace midair::samples
