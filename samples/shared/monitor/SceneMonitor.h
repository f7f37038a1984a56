#pragma once

#include "samples/shared/monitor/Monitor.h"

#include <osgMidair/HapticScene>

#include <osg/Camera>

#include <functional>
#include <memory>
#include <string>

namespace CLI
{
class App;
}

namespace midair::samples
{

/// Adds --monitor, --monitor-token-file and --monitor-host. \a options must outlive the parsing.
void addMonitorOptions(CLI::App& app, MonitorOptions& options);

/// The operator's page of a program with a haptic scene, if the options ask for one:
///
///     MonitorOptions options;
///     addMonitorOptions(app, options);                              // --monitor and its like
///     SceneMonitor monitor(options, *scene, "my-program: piano");   // throws if it can't serve
///     monitor.show(*viewer.getCamera());                            // the picture
///
/// Frames never wait for it: a separate thread reads statistics ten times a second, and pictures
/// are taken at most twice a second, while somebody looks.
class SceneMonitor
{
public:
    /// \a name: the program and what it shows. \a followMute is called on a thread of the page
    /// after the page has muted or unmuted the scene; the page waits for it. Throws
    /// std::runtime_error like Monitor.
    SceneMonitor(const MonitorOptions& options,
                 osgMidair::HapticScene& scene,
                 const std::string& name,
                 std::function<void()> followMute = {});
    /// Silences the array until the scene's next frame and ends the page. Waits some seconds for
    /// requests in progress.
    ~SceneMonitor();
    SceneMonitor(const SceneMonitor&) = delete;
    SceneMonitor& operator=(const SceneMonitor&) = delete;

    /// Takes the page's pictures from \a camera by an additional final draw callback. Call it
    /// before the viewer's first frame.
    void show(osg::Camera& camera);
    /// Sets the reason why there is no picture.
    void showNothing(const std::string& why);

    /// Returns null if there is no page.
    const Monitor* getMonitor() const { return _monitor.get(); }

private:
    class Picture;
    class Readback;
    class Source;

    std::shared_ptr<Source> _source;
    std::shared_ptr<Monitor> _monitor;
};

} // namespace midair::samples
