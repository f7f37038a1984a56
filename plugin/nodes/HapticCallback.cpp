#include "plugin/engine/HapticEngine.h"
#include "plugin/engine/SceneAccess.h"
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

constexpr const char* kNeverCalled = "its node is in no scene that is shown, or the viewer's "
                                     "eventTraversal() is not called; without "
                                     "that, add it as an update callback";

bool isAmong(osg::Callback* first, const osg::Callback& wanted)
{
    osg::Callback* one = first;
    while (one && one != &wanted)
        one = one->getNestedCallback();
    return one != nullptr;
}

} // namespace

HapticCallback::HapticCallback(const HapticSettings& settings) : _settings(settings) {}

// OSG tells a callback nothing of traversals that never come.
HapticCallback::~HapticCallback()
{
    if (!_engine)
        OSG_WARN << "osgMidair: a HapticCallback has played nothing: " << kNeverCalled << std::endl;
}

void HapticCallback::operator()(osg::Node* node, osg::NodeVisitor* visitor)
{
    osgGA::EventVisitor* event = visitor->asEventVisitor();
    const bool isUpdate = visitor->getVisitorType() == osg::NodeVisitor::UPDATE_VISITOR;
    osg::ref_ptr<HapticEngine> engine = this->engine();
    if ((event || isUpdate) && (!engine || engine->root() != node))
    {
        engine = new HapticEngine(*node, _settings, OwnerKind::CALLBACK);
        engine->setDeviceCallback(_deviceCallback);
        engine->setPlace(
            [self = osg::observer_ptr<HapticCallback>(this)](const osg::Node& root)
            {
                osg::ref_ptr<HapticCallback> callback;
                if (!self.lock(callback)) return false;
                auto& where = const_cast<osg::Node&>(root); // has getters of two kinds
                return isAmong(where.getEventCallback(), *callback) ||
                       isAmong(where.getUpdateCallback(), *callback);
            });
        const std::lock_guard<std::mutex> lock(_mutex);
        if (_engine) _muted = _engine->isMuted();
        engine->setMuted(_muted);
        _engine.swap(engine); // the old one dies outside the lock
    }
    engine = this->engine();
    if (engine && (event || isUpdate)) engine->noteVisit();
    if (event && engine->follow(event->getActionAdapter()))
        SceneKeys::addTo(event->getActionAdapter(), *engine);
    if (osgGA::GUIActionAdapter* view = isUpdate ? engine->followAbove(*node) : nullptr)
        SceneKeys::addTo(view, *engine);
    traverse(node, visitor);
}

// The engine is replaced when another node is played, while any thread may ask for it.
osg::ref_ptr<HapticEngine> HapticCallback::engine() const
{
    const std::lock_guard<std::mutex> lock(_mutex);
    return _engine;
}

void HapticCallback::setDeviceCallback(DeviceCallback* callback)
{
    _deviceCallback = callback;
    const osg::ref_ptr<HapticEngine> engine = this->engine();
    if (engine) engine->setDeviceCallback(callback);
}

void HapticCallback::setMuted(bool muted)
{
    const std::lock_guard<std::mutex> lock(_mutex);
    _muted = muted;
    if (_engine) _engine->setMuted(muted);
}

// A key mutes the engine alone.
bool HapticCallback::getMuted() const
{
    const osg::ref_ptr<HapticEngine> engine = this->engine();
    return engine ? engine->isMuted() : _muted.load();
}

HapticStatistics HapticCallback::getStatistics() const
{
    const osg::ref_ptr<HapticEngine> engine = this->engine();
    if (engine) return engine->statistics();
    HapticStatistics none;
    none.told.push_back(
        toPublic({midair::base::MessageCode::VIEWER_SILENT,
                  std::string("the HapticCallback plays nothing: ") + kNeverCalled}));
    none.messages.push_back(none.told.back().text);
    return none;
}

osg::ref_ptr<const HapticField> HapticCallback::getField() const
{
    const osg::ref_ptr<HapticEngine> engine = this->engine();
    return engine ? engine->field() : nullptr;
}

} // namespace osgMidair
