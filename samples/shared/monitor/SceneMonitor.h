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

/// The operator's page of a program with a haptic scene, or none if the options ask for none:
///
///     MonitorOptions options;
///     addMonitorOptions(app, options);                              // --monitor and its like
///     SceneMonitor monitor(options, *scene, "my-program: piano");   // throws if it can't serve
///     monitor.show(*viewer.getCamera());                            // the picture
///
/// No frame waits for it: statistics are read ten times a second by a thread of its own, and a
/// picture is taken at most twice a second, while somebody looks.
class SceneMonitor
{
public:
    /// \a name: of the program and what it shows. \a followMute: called, on a thread of the page,
    /// when the page has muted the scene or lets it play; the page waits for it. Throws
    /// std::runtime_error as Monitor does.
    SceneMonitor(const MonitorOptions& options,
                 osgMidair::HapticScene& scene,
                 const std::string& name,
                 std::function<void()> followMute = {});
    /// Silences the array until the scene's next frame, and ends the page, for which it waits some
    /// seconds where somebody is being served.
    ~SceneMonitor();
    SceneMonitor(const SceneMonitor&) = delete;
    SceneMonitor& operator=(const SceneMonitor&) = delete;

    /// Takes the page's pictures from what \a camera draws, by a final draw callback that is added
    /// to those it has. Before the viewer's first frame.
    void show(osg::Camera& camera);
    /// Says why there is no picture.
    void showNothing(const std::string& why);

    /// Null if no page was asked for.
    const Monitor* getMonitor() const { return _monitor.get(); }

private:
    class Picture;
    class Readback;
    class Source;

    std::shared_ptr<Source> _source;
    std::shared_ptr<Monitor> _monitor;
};

} // namespace midair::samples
