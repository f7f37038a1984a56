#include "plugin/engine/OwnedEngine.h"
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

/// Returns the view of \a device, which OSG doesn't pass to a device.
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
    _property(property),
    _engine(std::make_unique<OwnedEngine>(_settings, OwnerKind::DEVICE))
{
    setCapabilities(RECEIVE_EVENTS); // otherwise checkEvents() is never called
}

HapticDevice::~HapticDevice()
{
    const std::string why = _engine->get() ? std::string() : whySilent();
    if (!why.empty())
        OSG_WARN << "osgMidair: a HapticDevice has played nothing: " << why << std::endl;
}

// OSG notifies a device neither of its view nor of missing calls for events.
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
    const auto isInPlace = [self = osg::observer_ptr<HapticDevice>(this)](const osg::Node& root)
    {
        osg::ref_ptr<HapticDevice> device;
        osgViewer::View* where = self.lock(device) ? viewOf(device.get()) : nullptr;
        return where && where->getSceneData() == &root;
    };
    const osg::ref_ptr<HapticEngine> engine = _engine->playing(*scene, isInPlace, &_property);
    engine->follow(*view->getViewerBase());
    SceneKeys::addTo(view, *engine);
    return false;
}

void HapticDevice::setDeviceCallback(DeviceCallback* callback)
{
    _engine->setDeviceCallback(callback);
}

DeviceCallback* HapticDevice::getDeviceCallback() const
{
    return _engine->deviceCallback();
}

void HapticDevice::setMessageCallback(MessageCallback* callback)
{
    _engine->setMessageCallback(callback);
}

MessageCallback* HapticDevice::getMessageCallback() const
{
    return _engine->messageCallback();
}

std::vector<HapticMessage> HapticDevice::getActiveMessages() const
{
    return activeOf(getStatistics().told);
}

void HapticDevice::clearMessages()
{
    _engine->clearMessages();
}

void HapticDevice::setMuted(bool muted)
{
    _engine->setMuted(muted);
}

bool HapticDevice::getMuted() const
{
    return _engine->isMuted();
}

HapticStatistics HapticDevice::getStatistics() const
{
    const std::string why = whySilent();
    return _engine->statistics(why.empty() ? "" : "the HapticDevice plays nothing: " + why);
}

osg::ref_ptr<const HapticField> HapticDevice::getField() const
{
    return _engine->field();
}

} // namespace osgMidair
