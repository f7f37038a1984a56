#pragma once

#include <osgMidair/HandSource>
#include <osgMidair/HapticScene>
#include <osgMidair/HapticSettings>
#include <osgMidair/HapticStatistics>
#include <osgMidair/TouchCallback>

#include <osg/Group>
#include <osg/Vec3d>

#include <cstdint>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

namespace midair::samples
{

/// Name and texts of an installation.
struct InstallationTitle
{
    std::string name;    ///< "toybox"; the program is midair-toybox
    std::string purpose; ///< a sentence for --help
    std::string invites; ///< invitation on the screen
};

/// Camera of the screen; scene units are metres.
struct Viewpoint
{
    osg::Vec3d eye = {0.075, -1.20, 0.085};
    osg::Vec3d centre = {-0.010, 0.0, 0.0};
    osg::Vec3d up = osg::Z_AXIS;
    double fovy_deg = 25.6; ///< over the screen's height
};

/// The scene to build.
struct Stage
{
    osgMidair::HapticScene& haptics; ///< root of haptic objects
    osg::Group& lit;                 ///< root of visible objects, above haptics, with lights
    std::uint32_t seed = 1;          ///< random seed, for repeatable runs
    bool areHandsKnown = false;      ///< there is a hand source
};

/// State of a frame, for an installation.
struct Moment
{
    double time_s = 0.0;         ///< since the start; in headless runs 1/60 s per frame
    double step_s = 0.0;         ///< since the last frame
    bool isSomebodyThere = true; ///< hands are tracked now or were shortly before, or can't be
                                 ///< tracked
    const osgMidair::HapticStatistics& statistics; ///< of the previous frame
};

/// One installation: its scene, behaviour and report. runInstallation() does the rest: windows,
/// pictures, muting and restarts. All functions are called on the frame thread.
class Installation
{
public:
    Installation() = default;
    Installation(const Installation&) = delete;
    Installation& operator=(const Installation&) = delete;
    virtual ~Installation() = default;

    virtual InstallationTitle title() const = 0;
    /// Adds its own command-line options.
    virtual void addOptions(CLI::App& /*app*/) {}
    /// Returns the default array for \a device; an empty device is sim:.
    virtual std::string arrayOf(const std::string& /*device*/) const { return "octagon"; }
    /// Changes the default settings of the scene; the command line overrides them.
    virtual void arrange(osgMidair::HapticSettings& /*settings*/) {}
    /// Builds the scene once, after the options are parsed. An exception ends the program.
    virtual void build(Stage& stage) = 0;
    virtual Viewpoint viewpoint() const { return {}; }
    /// Returns the largest height of the ground, m. It is always below the initial scene.
    virtual double ground_m() const { return 1.0; }
    /// Fills \a hands with a simulated visitor's at \a time_s, for --hands demo. Returns false if
    /// there are none at that time.
    virtual bool demonstrate(double /*time_s*/, std::vector<osgMidair::Hand>& /*hands*/)
    {
        return false;
    }
    /// Called before each frame.
    virtual void update(const Moment& now) = 0;
    /// \{ Called for touches of objects with touch events, as in TouchCallback. Their force is at
    /// most what a fingertip gets at the strongest place of the field.
    virtual void touched(const osgMidair::Touch& /*touch*/) {}
    virtual void stroked(const osgMidair::Touch& /*touch*/) {}
    virtual void left(const osgMidair::Touch& /*touch*/) {}
    /// \}
    /// Called for a key press (osgGA::GUIEventAdapter). The shell handles F8 and Escape.
    virtual void pressed(int /*key*/) {}
    /// Returns true when the installation has ended; the program then ends.
    virtual bool isOver() const { return false; }
    /// Returns false if it can't be rehearsed in the simulator, because it stores results.
    virtual bool canRehearse() const { return true; }
    /// Returns true if the array must be silent without hands, where hands are tracked.
    virtual bool restsAlone() const { return true; }
    /// Returns the names of the overlays for visitors.
    virtual std::vector<std::string> overlays() const { return {"hands"}; }
    /// Returns a line for the screen beside the invitation; may be empty.
    virtual std::string caption() const { return {}; }
    /// Adds its own figures to the report.
    virtual void report(nlohmann::ordered_json& figures) const = 0;
};

/// Runs \a installation with the command line and returns the exit status. Call it once, from
/// main().
int runInstallation(Installation& installation, int argc, char** argv);

} // namespace midair::samples
