#include "plugin/engine/HapticEngine.h"

#include <osgMidair/HapticDevice>

#include <osg/GraphicsContext>
#include <osgViewer/GraphicsWindow>
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
    {
        auto* window = dynamic_cast<osgViewer::GraphicsWindow*>(context);
        if (!window) continue;
        osgViewer::GraphicsWindow::Views views;
        window->getViews(views);
        for (osgViewer::View* view : views)
        {
            const auto& devices = view->getDevices();
            if (std::find(devices.begin(), devices.end(), device) != devices.end()) return view;
        }
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

HapticDevice::~HapticDevice() = default;

bool HapticDevice::checkEvents()
{
    osgViewer::View* view = viewOf(this);
    osg::Node* scene = view ? view->getSceneData() : nullptr;
    if (!scene || !view->getViewerBase()) return false;
    if (!_engine || _engine->root() != scene)
    {
        _engine = new HapticEngine(*scene, _settings, OwnerKind::DEVICE);
        _engine->setDefaultProperty(_property);
    }
    _engine->follow(*view->getViewerBase());
    return false;
}

HapticStatistics HapticDevice::getStatistics() const
{
    return _engine ? _engine->statistics() : HapticStatistics();
}

} // namespace osgMidair
