#include "plugin/display/DisplayOfUser.h"
#include "plugin/engine/OwnedEngine.h"
#include "plugin/engine/SceneKeys.h"

#include <osgMidair/HapticCallback>

#include <osg/Notify>
#include <osg/observer_ptr>
#include <osgGA/EventVisitor>

#include <string>

namespace osgMidair
{

namespace
{

constexpr const char* kNeverCalled = "its node is in no displayed scene, or the viewer's "
                                     "eventTraversal() is not called; in that case "
                                     "add it as an update callback";

bool isAmong(osg::Callback* first, const osg::Callback& wanted)
{
    osg::Callback* one = first;
    while (one && one != &wanted)
        one = one->getNestedCallback();
    return one != nullptr;
}

} // namespace

HapticCallback::HapticCallback(const HapticSettings& settings) :
    _settings(settings),
    _engine(std::make_unique<OwnedEngine>(_settings, OwnerKind::CALLBACK))
{
}

// OSG doesn't notify a callback of missing traversals.
HapticCallback::~HapticCallback()
{
    if (!_engine->get())
        OSG_WARN << "osgMidair: a HapticCallback has played nothing: " << kNeverCalled << std::endl;
}

void HapticCallback::operator()(osg::Node* node, osg::NodeVisitor* visitor)
{
    osgGA::EventVisitor* event = visitor->asEventVisitor();
    const bool isUpdate = visitor->getVisitorType() == osg::NodeVisitor::UPDATE_VISITOR;
    if (event || isUpdate)
    {
        const auto isInPlace =
            [self = osg::observer_ptr<HapticCallback>(this)](const osg::Node& root)
        {
            osg::ref_ptr<HapticCallback> callback;
            if (!self.lock(callback)) return false;
            auto& where = const_cast<osg::Node&>(root); // has two kinds of getters
            return isAmong(where.getEventCallback(), *callback) ||
                   isAmong(where.getUpdateCallback(), *callback);
        };
        const osg::ref_ptr<HapticEngine> engine = _engine->playing(*node, isInPlace);
        if (event && engine->follow(event->getActionAdapter()))
        {
            SceneKeys::addTo(event->getActionAdapter(), *engine);
            showOnDisplayOfUser(event->getActionAdapter());
        }
        if (osgGA::GUIActionAdapter* view = isUpdate ? engine->followAbove(*node) : nullptr)
        {
            SceneKeys::addTo(view, *engine);
            showOnDisplayOfUser(view);
        }
    }
    traverse(node, visitor);
}

void HapticCallback::setDeviceCallback(DeviceCallback* callback)
{
    _engine->setDeviceCallback(callback);
}

DeviceCallback* HapticCallback::getDeviceCallback() const
{
    return _engine->deviceCallback();
}

void HapticCallback::setMessageCallback(MessageCallback* callback)
{
    _engine->setMessageCallback(callback);
}

MessageCallback* HapticCallback::getMessageCallback() const
{
    return _engine->messageCallback();
}

std::vector<HapticMessage> HapticCallback::getActiveMessages() const
{
    return activeOf(getStatistics().told);
}

void HapticCallback::clearMessages()
{
    _engine->clearMessages();
}

void HapticCallback::setMuted(bool muted)
{
    _engine->setMuted(muted);
}

bool HapticCallback::getMuted() const
{
    return _engine->isMuted();
}

HapticStatistics HapticCallback::getStatistics() const
{
    return _engine->statistics(
        _engine->get() ? "" : std::string("the HapticCallback plays nothing: ") + kNeverCalled);
}

osg::ref_ptr<const HapticField> HapticCallback::getField() const
{
    return _engine->field();
}

} // namespace osgMidair
