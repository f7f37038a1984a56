#include "plugin/engine/HapticEngine.h"
#include "plugin/engine/SceneAccess.h"
#include "plugin/engine/SceneKeys.h"

#include <osgMidair/HapticDevice>

#include <osg/Camera>
#include <osg/GraphicsContext>
#include <osg/Notify>
#include <osg/observer_ptr>
#include <osgViewer/View>

#include <algorithm>

namespace osgMidair
{

namespace
{

/// Returns the view that \a device was added to, which OSG doesn't tell a device.
osgViewer::View* viewOf(osgGA::Device* device)
{
    for (osg::GraphicsContext* context : osg::GraphicsContext::getAllRegisteredGraphicsContexts())
        for (osg::Camera* camera : context->getCameras())
        {
            // Windows and off-screen buffers alike.
            auto* view = dynamic_cast<osgViewer::View*>(camera->getView());
            if (!view) continue;
            const auto& devices = view->getDevices();
            if (std::find(devices.begin(), devices.end(), device) != devices.end()) return view;
        }
    return nullptr;
}

} // namespace

HapticDevice::HapticDevice(const HapticSettings& settings, const HapticProperty& property) :
    _settings(settings),
    _property(property)
{
    setCapabilities(RECEIVE_EVENTS); // else checkEvents() is never called
}

HapticDevice::~HapticDevice()
{
    const std::string why = _engine ? std::string() : whySilent();
    if (!why.empty())
        OSG_WARN << "osgMidair: a HapticDevice has played nothing: " << why << std::endl;
}

// OSG tells a device neither the view that it is added to nor that nobody asks it for events.
std::string HapticDevice::whySilent() const
{
    switch (_state)
    {
    case State::NOT_ASKED:
        return "it is in no view, or the viewer's eventTraversal() is not called";
    case State::NO_VIEW:
        return "its view has no window or off-screen buffer";
    case State::NO_SCENE:
        return "its view shows no scene";
    case State::FOLLOWS:
        break;
    }
    return {};
}

bool HapticDevice::checkEvents()
{
    osgViewer::View* view = viewOf(this);
    osg::Node* scene = view ? view->getSceneData() : nullptr;
    _state = !view ? State::NO_VIEW : !scene ? State::NO_SCENE : State::FOLLOWS;
    if (!scene || !view->getViewerBase()) return false;
    osg::ref_ptr<HapticEngine> engine = this->engine();
    if (!engine || engine->root() != scene)
    {
        engine = new HapticEngine(*scene, _settings, OwnerKind::DEVICE);
        engine->setUnmarkedProperty(_property);
        engine->setDeviceCallback(_deviceCallback);
        engine->setPlace(
            [self = osg::observer_ptr<HapticDevice>(this)](const osg::Node& root)
            {
                osg::ref_ptr<HapticDevice> device;
                osgViewer::View* where = self.lock(device) ? viewOf(device.get()) : nullptr;
                return where && where->getSceneData() == &root;
            });
        const std::lock_guard<std::mutex> lock(_mutex);
        if (_engine) _muted = _engine->isMuted();
        engine->setMuted(_muted);
        _engine.swap(engine); // the old one dies outside the lock
    }
    engine = this->engine();
    engine->noteVisit();
    engine->follow(*view->getViewerBase());
    SceneKeys::addTo(view, *engine);
    return false;
}

// The engine is replaced when another node is played, while any thread may ask for it.
osg::ref_ptr<HapticEngine> HapticDevice::engine() const
{
    const std::lock_guard<std::mutex> lock(_mutex);
    return _engine;
}

void HapticDevice::setDeviceCallback(DeviceCallback* callback)
{
    _deviceCallback = callback;
    const osg::ref_ptr<HapticEngine> engine = this->engine();
    if (engine) engine->setDeviceCallback(callback);
}

void HapticDevice::setMuted(bool muted)
{
    const std::lock_guard<std::mutex> lock(_mutex);
    _muted = muted;
    if (_engine) _engine->setMuted(muted);
}

// A key mutes the engine alone.
bool HapticDevice::getMuted() const
{
    const osg::ref_ptr<HapticEngine> engine = this->engine();
    return engine ? engine->isMuted() : _muted.load();
}

HapticStatistics HapticDevice::getStatistics() const
{
    const osg::ref_ptr<HapticEngine> engine = this->engine();
    if (_state == State::FOLLOWS && engine) return engine->statistics();
    HapticStatistics none = engine ? engine->statistics() : HapticStatistics();
    none.told.push_back(toPublic({midair::base::MessageCode::VIEWER_SILENT,
                                  "the HapticDevice plays nothing: " + whySilent()}));
    none.messages.push_back(none.told.back().text);
    return none;
}

osg::ref_ptr<const HapticField> HapticDevice::getField() const
{
    const osg::ref_ptr<HapticEngine> engine = this->engine();
    return engine ? engine->field() : nullptr;
}

} // namespace osgMidair
