#include "haptics/base/UserEnvironment.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"
#include "samples/installations/shell/Ground.h"
#include "samples/installations/shell/Installation.h"
#include "samples/installations/shell/InstallationOptions.h"
#include "samples/installations/shell/InstallationRecord.h"
#include "samples/installations/shell/Looks.h"
#include "samples/installations/shell/MuteMemory.h"
#include "samples/installations/shell/ServiceNotifier.h"
#include "samples/shared/DisplayOptions.h"
#include "samples/shared/monitor/SceneMonitor.h"
#include "samples/shared/views/ShownObject.h"
#include "samples/shared/views/Signals.h"

#include <osgMidair/HapticOverlays>
#include <osgMidair/HapticScene>
#include <osgMidair/Hud>

#include <osgDB/WriteFile>
#include <osgGA/GUIEventHandler>
#include <osgViewer/Viewer>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <complex>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

/// Default pressure cap at control points: visitors' hands must not get all that an array can do.
constexpr double kMaxPressure_Pa = 3000.0;

/// Timeout for opening an array.
constexpr double kOpening_s = 10.0;

/// Returns the scene's settings: defaults, overridden by \a installation, overridden by the command
/// line. Throws std::runtime_error for invalid settings.
osgMidair::HapticSettings settingsOf(Installation& installation, const InstallationOptions& options)
{
    osgMidair::HapticSettings settings;
    settings.array = installation.arrayOf(options.device);
    settings.device = "sim:";
    settings.maxPressure = kMaxPressure_Pa;
    installation.arrange(settings);
    std::string error;
    for (const auto& [name, text] : options.settings)
        if (!settings.set(name, text, error)) throw std::runtime_error(error);
    if (!options.array.empty() && !settings.set("array", options.array, error))
        throw std::runtime_error(error);
    if (!options.device.empty() && !settings.set("device", options.device, error))
        throw std::runtime_error(error);
    settings.device = withHold(settings.device);
    return settings;
}

/// The simulated visitor of --hands demo.
class DemonstratedHands : public osgMidair::HandSource
{
public:
    explicit DemonstratedHands(Installation& installation) : _installation(installation) {}
    bool getHands(double time_s, std::vector<osgMidair::Hand>& hands) override
    {
        hands.clear();
        const bool isThere = _installation.demonstrate(time_s, hands) && !hands.empty();
        const osg::Vec3d tip = isThere ? hands.front().joints[kIndexTip].position : osg::Vec3d();
        if (isThere && _wasThere && time_s > _last_s)
            _fastest_m_s = std::max(_fastest_m_s, (tip - _lastTip).length() / (time_s - _last_s));
        _wasThere = isThere;
        _last_s = time_s;
        _lastTip = tip;
        return isThere;
    }
    std::string getStatus() const override { return "demo: the installation's own visitor"; }
    /// Returns the largest speed of the index fingertip.
    double fastest_m_s() const { return _fastest_m_s; }

private:
    static constexpr std::size_t kIndexTip = 10;

    Installation& _installation;
    osg::Vec3d _lastTip;
    double _last_s = 0.0;
    bool _wasThere = false;
    double _fastest_m_s = 0.0;
};

constexpr double kFrameTime_s = 1.0 / 60.0;
/// Without a display only pictures need drawing. Every kDrawn-th frame is drawn nevertheless, to
/// detect memory that grows by drawing.
constexpr int kDrawn = 60;

void sleepUntil(double time_s)
{
    const double left_s = time_s - base::steadySeconds();
    if (left_s > 0.0) std::this_thread::sleep_for(std::chrono::duration<double>(left_s));
}

/// The scene of an installation with its sign on the screen, the mute and its memory, the array's
/// rest without visitors, and the record of the run.
class InstallationShell
{
public:
    /// Throws exceptions of the installation's build(), and std::runtime_error for invalid
    /// settings.
    InstallationShell(Installation& installation, const InstallationOptions& options) :
        _installation(installation),
        _options(options),
        _title(installation.title()),
        _program("midair-" + _title.name),
        _root(new osg::Group),
        _haptics(new osgMidair::HapticScene),
        _overlays(new osgMidair::HapticOverlays),
        _mute{{options.state, static_cast<double>(std::time(nullptr))}, {}, {}}
    {
        _haptics->setName(_title.name);
        applySettings();
        chooseHands();
        _haptics->setTouchCallback(new Touches(*this));
        _haptics->addChild(_overlays);
        const std::vector<std::string> shown =
            options.overlays.empty() ? installation.overlays() : options.overlays;
        if (!shown.empty()) _overlays->showOnly(shown);
        // Hide the list of keys from visitors, but not from somebody who names overlays.
        if (options.overlays.empty()) _overlays->get<osgMidair::Hud>()->setKeyTime(0.0);
        for (const auto& [name, value] : options.numbers)
            _overlays->setNumber(name, value);
        if (options.plain) _overlays->get<osgMidair::Hud>()->setPlain(true);
        const osg::ref_ptr<osg::Group> bright = lit(_haptics);
        _root->addChild(bright);
        _root->addChild(_sign.node());
        _sign.setInvitation(_title.invites);
        Stage stage{*_haptics, *bright, options.seed, _visitors.areHandsKnown};
        installation.build(stage);
        if (!_mute.memory.reason().empty()) say(_mute.memory.reason());
        _mute.isUnwrittenTold = !_mute.memory.isWritable();
        _mute.isOn = options.muted || _mute.memory.startsMuted();
        if (_mute.memory.startsMuted()) _mute.why = _mute.memory.reason();
        if (_visitors.areHandsKnown && installation.restsAlone()) openSilently();
        _haptics->setMuted(_mute.isOn);
        if (!_visitors.areHandsKnown && installation.restsAlone())
            say("no hands are tracked, so the array plays all the time; choose a tracker with "
                "--hands");
        // Follows signals that have come so far, too.
        _signals = std::make_unique<MuteSignals>(
            [this](bool isMuted) { _haptics->setMuted(isMuted); }, [this] { keepMute(); });
        // This mute isn't the operator's, so it isn't stored. A program that is asked to end has
        // not crashed, even if the signal has to end it during a long frame.
        _atStop = std::make_unique<SilenceAtStop>(
            [this]
            {
                // What somebody has muted in the frame that hangs is kept once it returns.
                if (_haptics->getMuted()) return;
                _mute.isOver = true;
                _haptics->setMuted(true);
            },
            [this] { tellUnwritten(_mute.memory.end()); });
    }

    osg::Group* root() { return _root; }
    /// \a display is the display in use, or null.
    void prepareFor(const osgMidair::DisplayView* display)
    {
        if (display && display->isFlipped()) _sign.turnForMirror();
        // Behind optics, dark areas show the room, which has its own ground.
        if (!display || !display->hasOptics())
            _root->addChild(
                Ground(*_root->getChild(0)->asGroup(), *_overlays, _installation.ground_m())
                    .node());
        if (display) say(display->getStatus());
    }
    /// Places the sign in front of the head, or in the window while the headset shows nothing.
    void showSignOn(const osgMidair::HeadsetView& headset)
    {
        _sign.standAt(headset.isRunning() ? std::optional<osg::Matrixd>(headset.getSheet())
                                          : std::nullopt);
    }
    osgMidair::HapticScene& haptics() { return *_haptics; }
    osgMidair::HapticOverlays& overlays() { return *_overlays; }

    /// Sets view, projection and background; \a aspect is width over height.
    void aim(osg::Camera& camera, double aspect) const
    {
        const Viewpoint from = _installation.viewpoint();
        camera.setViewMatrixAsLookAt(from.eye, from.centre, from.up);
        camera.setProjectionMatrixAsPerspective(from.fovy_deg, aspect, 0.01, 10.0);
        camera.setClearColor(kShownBackground);
    }

    /// Forwards keys of \a viewer to the installation.
    void listen(osgViewer::Viewer& viewer) { viewer.addEventHandler(new Keys(_installation)); }

    /// Runs one frame at scene time \a time_s and draws it if \a draw.
    void frame(osgViewer::Viewer& viewer, double time_s, bool draw)
    {
        const osgMidair::HapticStatistics before = _haptics->getStatistics();
        followVisitors(before, time_s);
        const Moment now{time_s, time_s - _past.time_s, _visitors.areThere, before};
        _installation.update(now);
        _past.time_s = time_s;
        _sign.setCaption(_installation.caption());
        _sign.setState(_mute.isOn, trouble(before));
        if (const osg::Viewport* viewport = viewer.getCamera()->getViewport())
            _sign.update(viewport->width(), viewport->height());
        if (!_options.plain) _overlays->get<osgMidair::Hud>()->setTopMargin(_sign.height());
        viewer.advance(time_s);
        viewer.eventTraversal();
        viewer.updateTraversal();
        if (draw) viewer.renderingTraversals();
        followMute();
        const double now_s = base::steadySeconds();
        const osgMidair::HapticStatistics after = _haptics->getStatistics();
        if (!std::exchange(_past.hasFrame, true)) tellUnwritten(_mute.memory.begin());
        _past.hasArray = _past.hasArray || (after.state != osgMidair::ArrayState::CLOSED &&
                                            after.state != osgMidair::ArrayState::OPENING);
        _record.addField(_haptics->getField().get());
        _record.addFrame({now_s, _mute.isOn, _visitors.mustRest}, after);
        if (_haptics->getRehearsed()) return; // a rehearsal is not reported to systemd
        _service.beat(now_s,
                      std::string(midair::bridge::stateName(after.state)) +
                          (_visitors.areThere ? "" : ", nobody is there"));
    }

    void addPicture(const std::string& file) { _record.addPicture(file); }
    /// Stores the current mute for a restart, asynchronously: muting waits neither for a frame nor
    /// for a disk. May be called from any thread.
    void keepMuteSoon() { _signals->wake(); }

    /// Ends the run: silences the array, ends the page and records in the state file that nothing
    /// crashed. Prints figures and writes them to the file \a report, if it is not empty. Returns
    /// false, with a message, if that fails or there never was an array.
    bool finish(std::unique_ptr<SceneMonitor> page, const std::string& report)
    {
        const osgMidair::HapticStatistics end = _haptics->getStatistics();
        _haptics->silence();
        page.reset(); // a later mute would not be stored
        _signals->end();
        followMute();
        _service.stop();
        tellUnwritten(_mute.memory.end());
        _record.print(_program, end);
        const bool hadArray =
            !_past.hasFrame || _past.hasArray || end.state != osgMidair::ArrayState::CLOSED;
        if (!hadArray) say("no array was connected");
        if (report.empty()) return hadArray;
        nlohmann::ordered_json json;
        json["installation"] = _title.name;
        json["seed"] = _options.seed;
        json["array"] = _haptics->getArray();
        json.update(_record.figures(end));
        if (_visitors.demo) json["visitor_m_s"] = _visitors.demo->fastest_m_s();
        nlohmann::ordered_json own;
        _installation.report(own);
        json["scene"] = own;
        std::ofstream file(report);
        file << json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
        file.close();
        if (file) return hadArray;
        say("can't write " + report);
        return false;
    }

private:
    class Touches : public osgMidair::TouchCallback
    {
    public:
        explicit Touches(InstallationShell& shell) : _shell(shell) {}
        void enter(const osgMidair::Touch& touch) override
        {
            const osgMidair::Touch felt = _shell._record.felt(touch);
            _shell._record.addTouch(felt);
            _shell._installation.touched(felt);
        }
        void stay(const osgMidair::Touch& touch) override
        {
            const osgMidair::Touch felt = _shell._record.felt(touch);
            _shell._record.addStroke(felt);
            _shell._installation.stroked(felt);
        }
        void leave(const osgMidair::Touch& touch) override
        {
            _shell._installation.left(_shell._record.felt(touch));
        }

    private:
        InstallationShell& _shell;
    };

    class Keys : public osgGA::GUIEventHandler
    {
    public:
        explicit Keys(Installation& installation) : _installation(installation) {}
        using osgGA::GUIEventHandler::handle;
        bool handle(const osgGA::GUIEventAdapter& event,
                    osgGA::GUIActionAdapter& /*action*/) override
        {
            if (event.getEventType() == osgGA::GUIEventAdapter::KEYDOWN)
                _installation.pressed(event.getKey());
            return false;
        }

    private:
        Installation& _installation;
    };

    struct Mute
    {
        MuteMemory memory;
        base::Mutex keeping; ///< guards reading the mute and storing it
        std::string why;
        bool isOn = false;
        std::atomic<bool> isOver{false};          ///< asked to end while a frame hangs
        std::atomic<bool> isUnwrittenTold{false}; ///< that the state can't be written
    };
    struct Visitors
    {
        bool areHandsKnown = false; ///< there is a hand source
        bool areThere = true;
        bool mustRest = false;                ///< nobody is there, so the array is silent
        double seen_s = -1e9;                 ///< time of the last hands; initially never
        osg::ref_ptr<DemonstratedHands> demo; ///< null: other hands
    };
    struct Past
    {
        bool hasFrame = false;
        bool hasArray = false; ///< an array was open
        double time_s = 0.0;   ///< of the last frame
    };

    // Without a chosen ear limit the scene is always a rehearsal: only a simulator plays.
    void applySettings()
    {
        const osgMidair::HapticSettings settings = settingsOf(_installation, _options);
        if (!whyEarLimitIsMissing(settings, _options).empty()) _haptics->setRehearsed(true);
        _haptics->setSettings(settings);
        // NOLINTNEXTLINE(concurrency-mt-unsafe): nobody here changes the environment
        const char* environment = std::getenv("OSG_MIDAIR_DEVICE");
        if (environment && *environment && withHold(environment) != environment)
            say("OSG_MIDAIR_DEVICE overrides --device and has no hold=1s: if the program hangs, "
                "the array plays on until the program is ended");
    }

    void chooseHands()
    {
        if (_options.hands == "demo")
        {
            _visitors.demo = new DemonstratedHands(_installation);
            _haptics->setHandSource(_visitors.demo);
            _visitors.areHandsKnown = true;
            return;
        }
        if (!_options.hands.empty()) _haptics->setHands(_options.hands);
        // NOLINTNEXTLINE(concurrency-mt-unsafe): nobody here changes the environment
        const char* environment = std::getenv("OSG_MIDAIR_HANDS");
        const std::string used = environment ? environment : _haptics->getHands();
        _visitors.areHandsKnown = !used.empty() && used != "none";
    }

    // A disabled scene opens neither tracker nor array, so enable it for one muted frame: both are
    // then ready, and nothing plays before a hand comes.
    void openSilently()
    {
        const osg::ref_ptr<osg::FrameStamp> stamp = new osg::FrameStamp;
        _haptics->setMuted(true);
        _haptics->update(stamp);
        _haptics->setEnabled(false);
        _haptics->update(stamp);
        const double end_s = base::steadySeconds() + kOpening_s;
        const auto isDone = [this]
        {
            const osgMidair::HapticStatistics now = _haptics->getStatistics();
            return now.processed >= now.snapshots;
        };
        while (!isDone() && base::steadySeconds() < end_s)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }

    // Follows mutes by F8, signals, the operator's page and any other caller of setMuted().
    void followMute()
    {
        if (_mute.isOver) return;
        const bool isMuted = _haptics->getMuted();
        if (isMuted == _mute.isOn) return;
        _mute.isOn = isMuted;
        _mute.why.clear();
        keepMute();
    }

    // Stores the scene's current mute: with concurrent mutes, the last one wins.
    void keepMute()
    {
        const base::Lock lock(_mute.keeping);
        tellUnwritten(_mute.memory.keep(_haptics->getMuted()));
    }

    // Told once, as soon as it is noticed: from any thread, as frames may hang.
    void tellUnwritten(bool isWritten)
    {
        if (isWritten || _mute.isUnwrittenTold.exchange(true)) return;
        say("\"" + _options.state + "\" can't be written: a restart will not remember the mute");
    }

    // A disabled scene is silent but still follows hands.
    void followVisitors(const osgMidair::HapticStatistics& now, double time_s)
    {
        if (!_visitors.areHandsKnown) return;
        if (now.hands > 0) _visitors.seen_s = time_s;
        _visitors.areThere = time_s - _visitors.seen_s <= _options.linger_s;
        _visitors.mustRest = !_visitors.areThere && _installation.restsAlone();
        if (_haptics->getEnabled() == _visitors.mustRest) _haptics->setEnabled(!_visitors.mustRest);
    }

    std::string trouble(const osgMidair::HapticStatistics& now) const
    {
        if (_mute.isOn) return _mute.why;
        switch (now.state)
        {
        case osgMidair::ArrayState::LOST:
            return "the array is lost";
        case osgMidair::ArrayState::FAULT:
            return "the array has failed";
        case osgMidair::ArrayState::CLOSED:
            return now.frames > 0 ? "no array is connected" : "";
        default:
            return {};
        }
    }

    void say(const std::string& text) const
    {
        std::fprintf(stderr, "%s: %s\n", _program.c_str(), text.c_str());
    }

    Installation& _installation;
    const InstallationOptions& _options;
    const InstallationTitle _title;
    const std::string _program;
    osg::ref_ptr<osg::Group> _root; ///< the first child is lit
    osg::ref_ptr<osgMidair::HapticScene> _haptics;
    osg::ref_ptr<osgMidair::HapticOverlays> _overlays;
    VisitorSign _sign;
    ServiceNotifier _service;
    InstallationRecord _record;
    Mute _mute;
    Visitors _visitors;
    Past _past;
    std::unique_ptr<MuteSignals> _signals; ///< both end before the members above that they change
    std::unique_ptr<SilenceAtStop> _atStop;
};

int headlessFrames(const InstallationOptions& options)
{
    if (options.minutes > 0.0) return static_cast<int>(options.minutes * 60.0 / kFrameTime_s);
    return options.frames > 0 ? options.frames : 240;
}

/// Returns the operator's page; \a shell stores its mutes.
std::unique_ptr<SceneMonitor> monitorOf(InstallationShell& shell,
                                        const Installation& installation,
                                        const InstallationOptions& options)
{
    return std::make_unique<SceneMonitor>(options.monitor,
                                          shell.haptics(),
                                          "midair-" + installation.title().name,
                                          [&shell] { shell.keepMuteSoon(); });
}

/// Sets options that are still empty for a run without a window. \a display may be null.
void fillHeadless(const osgMidair::DisplayView* display, InstallationOptions& options)
{
    const bool isSet = std::any_of(options.settings.begin(),
                                   options.settings.end(),
                                   [](const auto& setting) { return setting.first == "hands"; });
    if (options.hands.empty() && !isSet) options.hands = "demo";
    if (display && !display->isRehearsal())
        options.size = {display->getWidth(), display->getHeight()};
    if (options.size.first <= 0) options.size.first = 1200;
    if (options.size.second <= 0) options.size.second = 800;
}

bool runHeadless(Installation& installation, InstallationOptions options)
{
    const osg::ref_ptr<osgMidair::DisplayView> display = openDisplay(options.display);
    fillHeadless(display, options);
    const auto [width, height] = options.size;
    std::filesystem::create_directories(options.out);
    InstallationShell shell(installation, options);
    shell.prepareFor(display);
    auto monitor = monitorOf(shell, installation, options);
    osgViewer::Viewer viewer;
    viewer.setLightingMode(osg::View::NO_LIGHT);
    std::string problem;
    const double aspect = static_cast<double>(width) / height;
    const auto aim = [&shell, aspect](osg::Camera& camera) { shell.aim(camera, aspect); };
    const double fovy_deg = installation.viewpoint().fovy_deg;
    const bool draw = setUpOffscreen(viewer, width, height, fovy_deg, &problem);
    if (draw)
    {
        aim(*viewer.getCamera());
        monitor->show(*viewer.getCamera());
    }
    else
        monitor->showNothing(problem);
    viewer.setSceneData(shell.root());
    shell.listen(viewer);
    const std::unique_ptr<PictureTaker> camera =
        draw && options.pictures > 0
            ? std::make_unique<PictureTaker>(
                  *shell.root(), shell.overlays(), width, height, fovy_deg, aim, problem)
            : nullptr;
    if (camera) camera->showOn(display);
    const int frames = headlessFrames(options);
    // A slow machine draws fewer frames in this time.
    const double end_s =
        options.minutes > 0.0 ? base::steadySeconds() + 60.0 * options.minutes : 1e300;
    const int between = std::max(1, frames / std::max(1, options.pictures));
    int taken = 0;
    std::string unwritten;
    for (int i = 0;
         i < frames && base::steadySeconds() < end_s && !isStopAsked() && !installation.isOver();
         ++i)
    {
        const double begin_s = base::steadySeconds();
        shell.frame(viewer, i * kFrameTime_s, draw && i % kDrawn == kDrawn - 1);
        if (camera && i % between == between - 1)
        {
            const std::string file =
                fmt::format("{}/{}_{}.png", options.out, installation.title().name, ++taken);
            const osg::ref_ptr<osg::Image> image = camera->take();
            if (image && osgDB::writeImageFile(*image, file))
                shell.addPicture(file);
            else
                unwritten = "can't write " + file;
        }
        sleepUntil(begin_s + kFrameTime_s);
    }
    for (const std::string& why : {problem, unwritten})
        if (!why.empty()) std::fprintf(stderr, "pictures: %s\n", why.c_str());
    return shell.finish(std::move(monitor), options.out + "/report.json") && unwritten.empty();
}

void openWindow(osgViewer::Viewer& viewer, const InstallationOptions& options)
{
    if (options.size.first > 0)
        viewer.setUpViewInWindow(60, 60, options.size.first, options.size.second);
    else
        viewer.setUpViewOnSingleScreen(static_cast<unsigned int>(options.screen));
    viewer.setThreadingModel(osgViewer::ViewerBase::SingleThreaded);
    viewer.realize();
    osgViewer::ViewerBase::Windows windows;
    viewer.getWindows(windows);
    if (windows.empty()) throw std::runtime_error("can't open a window on the display");
    for (osgViewer::GraphicsWindow* window : windows)
        if (options.size.first == 0 && options.hands != "mouse:") window->useCursor(false);
}

bool runWindow(Installation& installation, const InstallationOptions& options)
{
    const osg::ref_ptr<osgMidair::DisplayView> display = openDisplay(options.display);
    InstallationShell shell(installation, options);
    shell.prepareFor(display);
    auto monitor = monitorOf(shell, installation, options);
    osgViewer::Viewer viewer;
    viewer.setLightingMode(osg::View::NO_LIGHT);
    openWindow(viewer, options);
    if (options.plain) viewer.setKeyEventSetsDone(0); // visitors can't end it with Escape
    monitor->show(*viewer.getCamera());
    viewer.setSceneData(shell.root());
    showOn(display, viewer);
    const auto headset = showInHeadset(options.display, viewer);
    shell.listen(viewer);
    const double start_s = base::steadySeconds();
    const double end_s = options.minutes > 0.0 ? start_s + 60.0 * options.minutes : 1e300;
    for (int i = 0; !viewer.done() && !isStopAsked() && !installation.isOver() &&
                    (options.frames == 0 || i < options.frames) && base::steadySeconds() < end_s;
         ++i)
    {
        const double begin_s = base::steadySeconds();
        const osg::Viewport& viewport = *viewer.getCamera()->getViewport();
        shell.aim(*viewer.getCamera(), viewport.width() / std::max(1.0, viewport.height()));
        if (headset) shell.showSignOn(*headset);
        shell.frame(viewer, begin_s - start_s, true);
        // Without vertical synchronisation frames would run as fast as possible. A headset has its
        // own clock.
        if (!headset || !headset->isRunning()) sleepUntil(begin_s + 0.5 * kFrameTime_s);
    }
    return shell.finish(std::move(monitor), {});
}

/// Rehearses the installation on its array in the simulator and returns a text about the effect of
/// ear limits.
std::string rehearsedEarNeed(Installation& installation,
                             const osgMidair::HapticSettings& settings,
                             InstallationOptions options)
{
    constexpr int kFrames = 240;
    // With a tracker, simulate a visitor; without one everything plays all the time.
    std::string hands = options.hands.empty() ? settings.hands : options.hands;
    if (hands.empty()) hands = base::userVariable("OSG_MIDAIR_HANDS").value_or("");
    options.hands = hands.empty() || hands == "none" ? "none" : "demo";
    options.state.clear();
    options.muted = false;
    EarNeedMeter meter(settings);
    if (!installation.canRehearse()) return describe(meter.need(), settings.array);
    InstallationShell shell(installation, options);
    osgViewer::Viewer viewer;
    viewer.setSceneData(shell.root());
    osg::ref_ptr<const osgMidair::HapticField> newest;
    for (int i = 0; i < kFrames && !isStopAsked() && !installation.isOver(); ++i)
    {
        const double begin_s = base::steadySeconds();
        shell.frame(viewer, i * kFrameTime_s, false);
        const osg::ref_ptr<const osgMidair::HapticField> field = shell.haptics().getField();
        if (field && field != newest)
        {
            std::vector<std::vector<std::complex<float>>> fields;
            for (unsigned int k = 0; k < field->getNumFields(); ++k)
                fields.push_back(field->getActivations(k));
            meter.add(fields);
            newest = field;
        }
        sleepUntil(begin_s + kFrameTime_s);
    }
    shell.haptics().silence();
    return describe(meter.need(), settings.array);
}

/// Returns false, with a message, if the operator has not chosen an ear limit.
bool mayStart(Installation& installation, const InstallationOptions& options)
{
    const osgMidair::HapticSettings settings = settingsOf(installation, options);
    const std::string why = whyEarLimitIsMissing(settings, options);
    if (why.empty()) return true;
    const std::string need = rehearsedEarNeed(installation, settings, options);
    std::fprintf(stderr,
                 "midair-%s: %s.\n%s\n",
                 installation.title().name.c_str(),
                 why.c_str(),
                 need.c_str());
    return false;
}

} // namespace

int runInstallation(Installation& installation, int argc, char** argv)
{
    InstallationOptions options;
    int status = 0;
    if (!parseInstallationOptions(installation, argc, argv, options, status)) return status;
    registerEmulatedDevices();
    catchStopSignals();
    catchMuteSignals();
    try
    {
        if (!mayStart(installation, options)) return 1;
        const bool isHeadless = options.headless || !haveDisplay();
        return (isHeadless ? runHeadless(installation, options) : runWindow(installation, options))
                   ? 0
                   : 1;
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "midair-%s: %s\n", installation.title().name.c_str(), error.what());
        return 1;
    }
}

} // namespace midair::samples
