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

/// What an installation is called and shows.
struct InstallationTitle
{
    std::string name;    ///< "toybox"; the program is midair-toybox
    std::string purpose; ///< a sentence for --help
    std::string invites; ///< what visitors are told on the screen
};

/// Where the screen looks from; scene units are metres.
struct Viewpoint
{
    osg::Vec3d eye = {0.075, -1.20, 0.085};
    osg::Vec3d centre = {-0.010, 0.0, 0.0};
    osg::Vec3d up = osg::Z_AXIS;
    double fovy_deg = 25.6; ///< of the screen's height
};

/// What an installation builds its scene in.
struct Stage
{
    osgMidair::HapticScene& haptics; ///< root of what is felt
    osg::Group& lit;                 ///< above it; has the lights: for what is only seen
    std::uint32_t seed = 1;          ///< of all that is drawn by lot, so that a run repeats
    bool areHandsKnown = false;      ///< there is a source of hands
};

/// A frame, as an installation sees it.
struct Moment
{
    double time_s = 0.0; ///< since the start; of headless runs a sixtieth of a second a frame
    double step_s = 0.0; ///< since the last frame
    bool isSomebodyThere = true; ///< hands are tracked, or were a little while ago; or none can be
    const osgMidair::HapticStatistics& statistics; ///< of the frame before
};

/// One installation: its scene, what happens in it and what is reported of it. All else, such as
/// windows, pictures, muting and restarts, is done by runInstallation(). All functions are called
/// on the thread of the frames.
class Installation
{
public:
    Installation() = default;
    Installation(const Installation&) = delete;
    Installation& operator=(const Installation&) = delete;
    virtual ~Installation() = default;

    virtual InstallationTitle title() const = 0;
    /// Adds options of its own to the command line.
    virtual void addOptions(CLI::App& /*app*/) {}
    /// The array where the command line names none, for the device that it names; empty: sim:.
    virtual std::string arrayOf(const std::string& /*device*/) const { return "octagon"; }
    /// Sets what the scene plays with; the command line comes after it.
    virtual void arrange(osgMidair::HapticSettings& /*settings*/) {}
    /// Builds the scene, once, after the options are known. What it throws ends the program.
    virtual void build(Stage& stage) = 0;
    virtual Viewpoint viewpoint() const { return {}; }
    /// The height of the ground, m, if it is lower than all that is shown at first.
    virtual double ground_m() const { return 1.0; }
    /// Fills \a hands with those of a visitor who tries the installation, at \a time_s: what
    /// --hands demo plays. Returns false if there are none then.
    virtual bool demonstrate(double /*time_s*/, std::vector<osgMidair::Hand>& /*hands*/)
    {
        return false;
    }
    /// Called before each frame.
    virtual void update(const Moment& now) = 0;
    /// \{ Touches of objects with touch events, as TouchCallback has them.
    virtual void touched(const osgMidair::Touch& /*touch*/) {}
    virtual void stroked(const osgMidair::Touch& /*touch*/) {}
    virtual void left(const osgMidair::Touch& /*touch*/) {}
    /// \}
    /// A key was pressed (of osgGA::GUIEventAdapter). F8 and Escape are the shell's.
    virtual void pressed(int /*key*/) {}
    /// True: it has ended by itself, and so does the program.
    virtual bool isOver() const { return false; }
    /// False: it can't be tried beforehand in the simulator, as it keeps what happens.
    virtual bool canRehearse() const { return true; }
    /// True: hands that are away silence the array, where hands are tracked at all.
    virtual bool restsAlone() const { return true; }
    /// Words of the overlays that visitors see.
    virtual std::vector<std::string> overlays() const { return {"hands"}; }
    /// What is said on the screen beside the invitation; empty: nothing.
    virtual std::string caption() const { return {}; }
    /// Adds figures of its own to the report.
    virtual void report(nlohmann::ordered_json& figures) const = 0;
};

/// Runs \a installation as the command line says, and returns the program's exit status. Called
/// once, from main().
int runInstallation(Installation& installation, int argc, char** argv);

} // namespace midair::samples
