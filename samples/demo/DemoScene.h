#pragma once

#include "samples/shared/monitor/Monitor.h"

#include <osgMidair/HapticOverlays>
#include <osgMidair/HapticScene>

#include <osg/MatrixTransform>

#include <string>
#include <utility>
#include <vector>

namespace midair::samples
{

/// Options of midair-demo.
struct DemoOptions
{
    std::string model; ///< any file that OSG reads; empty: the paper's star
    double size_m = 0.12;
    /// Settings of the scene and of the object as names and texts for HapticSettings::set() and
    /// HapticProperty::set(), in command-line order; others keep the values of the scene file or
    /// the defaults. A hand source FILE.csv is stored as recorded:FILE.csv?loop.
    std::vector<std::pair<std::string, std::string>> scene;
    std::vector<std::pair<std::string, std::string>> object;
    /// target peak pressure of the object; 0: as strong as the field stays accurate
    double pressure_Pa = 0.0;
    /// numbers of overlays, by the names of HapticOverlays::setNumber()
    std::vector<std::pair<std::string, double>> numbers;
    std::vector<std::string> overlays; ///< words of the overlays to show; empty: all
    bool still = false;                ///< the object stays in the middle, as with recorded hands
    int frames = 0; ///< 0: 240 without a display, else until the window is closed
    std::string out = "build/out";
    bool headless = false;
    bool benchmark = false;
    double zoom = 1.0; ///< magnification of pictures and window
    int width = 1200;
    int height = 800;
    std::string display; ///< display file, optionally with the prefix "sim:"; empty: an ordinary
                         ///< window
    MonitorOptions monitor;
};

/// Parses the command line. Returns false after --help or a wrong option; the program then exits
/// with \a status.
bool parseDemoOptions(int argc, char** argv, DemoOptions& options, int& status);

/// Returns the pose of the moving object at \a time_s: within 30 mm of the middle, turning about
/// the prism's axis and tilting. Deterministic.
osg::Matrix demoPose(double time_s);

/// Scene of midair-demo: the object in its array, with all overlays of the kit.
class DemoScene
{
public:
    /// Throws std::runtime_error if the model can't be read.
    explicit DemoScene(const DemoOptions& options);

    osg::Group* root() { return _root; }
    osgMidair::HapticScene& haptics() { return *_haptics; }
    osgMidair::HapticOverlays& overlays() { return *_overlays; }
    const std::string& name() const { return _name; }

    /// Moves the object to its pose at \a time_s. Objects of a scene file are not moved.
    void moveTo(double time_s);

    /// Looks from the open end of the prism, slightly off its axis.
    static void lookAt(osg::Vec3d& eye, osg::Vec3d& centre, osg::Vec3d& up);
    static constexpr double kFovy_deg = 25.6;

private:
    void wrap(const DemoOptions& options);
    void applySettings(const DemoOptions& options);
    void leaveToScene(const DemoOptions& options) const;

    std::string _name;
    bool _still = false;
    osg::ref_ptr<osg::Group> _root;
    osg::ref_ptr<osgMidair::HapticScene> _haptics;
    osg::ref_ptr<osg::MatrixTransform> _moved;
    osg::ref_ptr<osgMidair::HapticOverlays> _overlays;
};

} // namespace midair::samples
