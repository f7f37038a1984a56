#include "samples/shared/monitor/SceneMonitor.h"

#include "samples/shared/monitor/Monitor.h"
#include "samples/shared/monitor/ScenePicture.h"

#include <utility>

namespace midair::samples
{

namespace
{

/// A HapticScene for the page.
class SceneSource : public MonitorSource
{
public:
    SceneSource(osgMidair::HapticScene& scene, std::function<void()> followMute) :
        _scene(&scene),
        _followMute(std::move(followMute))
    {
    }

    MonitorReading read() const override
    {
        MonitorReading reading{_scene->getStatistics(), _scene->getMuted(), {}};
        const osg::ref_ptr<const osgMidair::HapticField> field = _scene->getField();
        const auto array = field ? field->getArray() : nullptr;
        if (array) reading.array = array->name;
        return reading;
    }
    void setMuted(bool muted) override
    {
        _scene->setMuted(muted);
        if (_followMute) _followMute();
    }

private:
    osg::ref_ptr<osgMidair::HapticScene> _scene;
    std::function<void()> _followMute;
};

} // namespace

SceneMonitor::SceneMonitor(const MonitorOptions& options,
                           osgMidair::HapticScene& scene,
                           const std::string& name,
                           std::function<void()> followMute)
{
    if (options.address.empty()) return;
    _picture = std::make_shared<ScenePicture>();
    _monitor = std::make_unique<Monitor>(
        options, name, std::make_shared<SceneSource>(scene, std::move(followMute)), _picture);
}

SceneMonitor::~SceneMonitor()
{
    if (_picture) _picture->end();
}

void SceneMonitor::show(osg::Camera& camera)
{
    if (_picture) _picture->show(camera);
}

void SceneMonitor::showNothing(const std::string& why)
{
    if (_picture) _picture->showNothing(why);
}

} // namespace midair::samples
