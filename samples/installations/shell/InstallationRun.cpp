#include "haptics/base/UserEnvironment.h"
#include "samples/installations/shell/EarChoice.h"
#include "samples/installations/shell/InstallationShell.h"
#include "samples/shared/monitor/SceneMonitor.h"
#include "samples/shared/views/EmulatedDevices.h"
#include "samples/shared/views/PictureTaker.h"
#include "samples/shared/views/Signals.h"

#include <osg/Timer>
#include <osgDB/WriteFile>
#include <osgViewer/Viewer>

#include <algorithm>
#include <chrono>
#include <complex>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

constexpr double kFrameTime_s = 1.0 / 60.0;
/// Without a display all that is drawn for is pictures; a frame in so many is drawn all the same,
/// so that what grows by drawing is seen.
constexpr int kDrawn = 60;

double steady_s()
{
    return osg::Timer::instance()->time_s();
}

void sleepUntil(double time_s)
{
    const double left_s = time_s - steady_s();
    if (left_s > 0.0) std::this_thread::sleep_for(std::chrono::duration<double>(left_s));
}

int headlessFrames(const InstallationOptions& options)
{
    if (options.minutes > 0.0) return static_cast<int>(options.minutes * 60.0 / kFrameTime_s);
    return options.frames > 0 ? options.frames : 240;
}

/// The operator's page, whose mutes \a shell keeps.
std::unique_ptr<SceneMonitor> monitorOf(InstallationShell& shell,
                                        const Installation& installation,
                                        const InstallationOptions& options)
{
    return std::make_unique<SceneMonitor>(options.monitor,
                                          shell.haptics(),
                                          "midair-" + installation.title().name,
                                          [&shell] { shell.keepMuteSoon(); });
}

bool runHeadless(Installation& installation, InstallationOptions options)
{
    const bool isSet = std::any_of(options.settings.begin(),
                                   options.settings.end(),
                                   [](const auto& setting) { return setting.first == "hands"; });
    if (options.hands.empty() && !isSet) options.hands = "demo";
    const int width = options.size.first > 0 ? options.size.first : 1200;
    const int height = options.size.second > 0 ? options.size.second : 800;
    std::filesystem::create_directories(options.out);
    InstallationShell shell(installation, options);
    auto monitor = monitorOf(shell, installation, options);
    osgViewer::Viewer viewer;
    viewer.setLightingMode(osg::View::NO_LIGHT);
    std::string problem;
    const auto aim = [&](osg::Camera& camera)
    { shell.aim(camera, static_cast<double>(width) / height); };
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
    const int frames = headlessFrames(options);
    // A machine that can't keep up draws fewer frames in these minutes.
    const double end_s = options.minutes > 0.0 ? steady_s() + 60.0 * options.minutes : 1e300;
    const int between = std::max(1, frames / std::max(1, options.pictures));
    int taken = 0;
    std::string unwritten;
    for (int i = 0; i < frames && steady_s() < end_s && !isStopAsked() && !installation.isOver();
         ++i)
    {
        const double begin_s = steady_s();
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
    monitor.reset(); // or it could mute once nobody keeps that any more
    return shell.finish(options.out + "/report.json") && unwritten.empty();
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
    InstallationShell shell(installation, options);
    auto monitor = monitorOf(shell, installation, options);
    osgViewer::Viewer viewer;
    viewer.setLightingMode(osg::View::NO_LIGHT);
    openWindow(viewer, options);
    if (options.plain) viewer.setKeyEventSetsDone(0); // visitors don't end it by Escape
    monitor->show(*viewer.getCamera());
    viewer.setSceneData(shell.root());
    shell.listen(viewer);
    const double start_s = steady_s();
    const double end_s = options.minutes > 0.0 ? start_s + 60.0 * options.minutes : 1e300;
    for (int i = 0; !viewer.done() && !isStopAsked() && !installation.isOver() &&
                    (options.frames == 0 || i < options.frames) && steady_s() < end_s;
         ++i)
    {
        const double begin_s = steady_s();
        const osg::Viewport& viewport = *viewer.getCamera()->getViewport();
        shell.aim(*viewer.getCamera(), viewport.width() / std::max(1.0, viewport.height()));
        shell.frame(viewer, begin_s - start_s, true);
        // A display without vertical synchronisation would be drawn as often as the processor can.
        sleepUntil(begin_s + 0.5 * kFrameTime_s);
    }
    monitor.reset();
    return shell.finish({});
}

/// Rehearses the installation in the simulator, on the array that would play, and says what ear
/// limits would leave of its fields.
std::string rehearsedEarNeed(Installation& installation,
                             const osgMidair::HapticSettings& settings,
                             InstallationOptions options)
{
    constexpr int kFrames = 240;
    // With a tracker its own visitor comes; without one all is played, all the time.
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
        const double begin_s = steady_s();
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

/// Returns false, having said why, while the operator has chosen no ear limit.
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
