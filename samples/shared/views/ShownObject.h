#pragma once

#include "samples/shared/views/Offscreen.h"

#include <osgMidair/DisplayView>
#include <osgMidair/HapticOverlays>
#include <osgMidair/HapticSurface>

#include <osg/Vec4>
#include <osgText/Font>

#include <functional>
#include <string>

namespace midair::samples
{

/// Returns the path of \a name ("models/star.obj") in the samples' folder: the installed one if the
/// program is installed, else the source tree's.
std::string sampleFile(const std::string& name);

/// Returns the font of pictures and signs: DejaVu Sans (Debian: fonts-dejavu-core), else OSG's own.
osg::ref_ptr<osgText::Font> labelFont();

/// Enables `sim:?board=autd3` in this program: emulated AUTD3 units.
void registerEmulatedDevices();

/// background colour
inline const osg::Vec4 kShownBackground(0.052F, 0.060F, 0.078F, 1.0F);

/// A model read by any OSG plugin, scaled to a size and centred, with materials that show its
/// shape.
struct ShownObject
{
    std::string name;              ///< file name without folders
    osg::ref_ptr<osg::Node> model; ///< metres; the centre of its bounding box is at the origin
    osg::ref_ptr<osg::Node> edges; ///< outline and creases, drawn over the field; not haptic
    osg::Vec3d extent_m;
    double scale = 1.0; ///< from the file's units to metres
    bool flat = false;  ///< drawn transparent, because the field's slice is in its plane
    /// The haptic node, to be put below a HapticScene: \a surface, or a plain group if tags in the
    /// file define the haptic parts.
    osg::ref_ptr<osg::Group> felt;
    osg::ref_ptr<osgMidair::HapticSurface> surface; ///< null: tags define the haptic parts
};

/// Reads \a path like MODEL.haptic and scales it to a largest extent of \a size_m (0: unchanged).
/// \a isOpaque draws flat models opaque, too. Throws std::runtime_error with the file's name.
ShownObject loadShownObject(const std::string& path, double size_m, bool isOpaque = false);

/// Returns a group with two lights (key and fill) and \a scene below it.
osg::ref_ptr<osg::Group> lit(osg::Node* scene);

/// Takes still pictures of a scene that another viewer runs, supersampled 2 x 2.
class PictureTaker
{
public:
    /// \a aim sets view, projection and background of the camera. Without OpenGL, \a problem is set
    /// to the reason and take() returns null.
    PictureTaker(osg::Node& scene,
                 osgMidair::HapticOverlays& overlays,
                 int width,
                 int height,
                 double fovy_deg,
                 const std::function<void(osg::Camera&)>& aim,
                 std::string& problem);

    /// Uses the projection of \a display, which may be null, from now on. Throws
    /// std::runtime_error.
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
