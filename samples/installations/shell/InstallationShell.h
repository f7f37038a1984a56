#pragma once

#include "samples/installations/shell/Installation.h"
#include "samples/installations/shell/InstallationOptions.h"
#include "samples/installations/shell/InstallationRecord.h"
#include "samples/installations/shell/Looks.h"
#include "samples/installations/shell/MuteMemory.h"
#include "samples/installations/shell/ServiceNotifier.h"
#include "samples/shared/views/Signals.h"

#include <osgMidair/HapticOverlays>
#include <osgMidair/HapticScene>

#include <osgViewer/Viewer>

#include <memory>
#include <mutex>
#include <string>

namespace midair::samples
{

/// Returns the settings of the scene of \a installation: the command line comes after the
/// installation, and both after the defaults. Throws std::runtime_error for settings that are not
/// understood.
osgMidair::HapticSettings settingsOf(Installation& installation,
                                     const InstallationOptions& options);

/// The scene of an installation with all that goes on around it: the sign on the screen, the mute
/// and its memory, the array's rest while nobody is there, and the record of the run.
class InstallationShell
{
public:
    /// Throws what the installation's build() does, and std::runtime_error for settings that are
    /// not understood.
    InstallationShell(Installation& installation, const InstallationOptions& options);

    osg::Group* root() { return _root; }
    osgMidair::HapticScene& haptics() { return *_haptics; }
    osgMidair::HapticOverlays& overlays() { return *_overlays; }

    /// Sets view, projection and background; \a aspect: width over height.
    void aim(osg::Camera& camera, double aspect) const;
    /// Sends keys of \a viewer to the installation.
    void listen(osgViewer::Viewer& viewer);

    /// Runs one frame at \a time_s of the scene's time; draws it if \a draw.
    void frame(osgViewer::Viewer& viewer, double time_s, bool draw);
    void addPicture(const std::string& file) { _record.addPicture(file); }
    /// Has a mute, or its end, kept over a restart. Any thread: who mutes waits neither for a
    /// frame, which may never come, nor for a disk.
    void keepMuteSoon() { _signals->wake(); }

    /// Ends the run: the array falls silent, and the state's file knows that nothing crashed.
    /// Prints figures and, if \a report names a file, writes them. Returns false, having said why,
    /// if that fails, or if there never was an array.
    bool finish(const std::string& report);

private:
    class Touches;
    class Keys;

    void applySettings();
    void chooseHands();
    void openSilently();
    void followMute();
    void keepMute();
    void followVisitors(const osgMidair::HapticStatistics& now, double time_s);
    std::string trouble(const osgMidair::HapticStatistics& now) const;
    void say(const std::string& text) const;

    Installation& _installation;
    const InstallationOptions& _options;
    const InstallationTitle _title;
    const std::string _program;
    osg::ref_ptr<osg::Group> _root;
    osg::ref_ptr<osgMidair::HapticScene> _haptics;
    osg::ref_ptr<osgMidair::HapticOverlays> _overlays;
    VisitorSign _sign;
    MuteMemory _memory;
    ServiceNotifier _service;
    InstallationRecord _record;
    std::mutex _keeping; ///< guards what is read of the scene and kept of it
    std::string _whyMuted;
    bool _hasBegun = false; ///< there was a frame
    bool _wasOpen = false;  ///< there was an array
    bool _isMuted = false;
    bool _areHandsKnown = false; ///< there is a source of hands
    bool _isSomebodyThere = true;
    bool _mustRest = false;     ///< nobody is there, so the array is silent
    double _handsSeen_s = -1e9; ///< never
    double _lastTime_s = 0.0;
    std::unique_ptr<MuteSignals> _signals; ///< the last two end before what they change
    std::unique_ptr<SilenceAtStop> _atStop;
};

} // namespace midair::samples
