#include "plugin/display/DisplayOfUser.h"
#include "plugin/engine/HapticEngine.h"
#include "plugin/engine/SceneAccess.h"
#include "plugin/engine/SceneKeys.h"
#include "plugin/hands/TouchTeller.h"
#include "plugin/settings/AllSettings.h"
#include "plugin/settings/UserOptions.h"

#include <osgMidair/HapticScene>

#include <osgGA/EventVisitor>

namespace osgMidair
{

HapticScene::HapticScene() : _engine(new HapticEngine(*this, _settings, OwnerKind::SCENE))
{
    setNumChildrenRequiringEventTraversal(1);
    setNumChildrenRequiringUpdateTraversal(1); // for loops without event traversal
}

HapticScene::HapticScene(const HapticScene& other, const osg::CopyOp& copyop) :
    osg::Group(other, copyop),
    HapticSettingsHolder(other),
    _engine(new HapticEngine(*this, _settings, OwnerKind::SCENE))
{
    _engine->setHandSource(other.getHandSource());
    _engine->setHeadSource(other.getHeadSource());
    _engine->setTouchCallback(other.getTouchCallback());
    _engine->setObstacles(other.getObstacles());
    _engine->setEars(other.getEars());
    _engine->setDeviceCallback(other.getDeviceCallback());
    _engine->setMessageCallback(other.getMessageCallback());
    _engine->setFieldCallback(other.getFieldCallback());
    _engine->setJoined(other.getJoined());
    // The base class doesn't copy these counts.
    setNumChildrenRequiringEventTraversal(getNumChildrenRequiringEventTraversal() + 1);
    setNumChildrenRequiringUpdateTraversal(getNumChildrenRequiringUpdateTraversal() + 1);
}

HapticScene::~HapticScene() = default;

void HapticScene::endReading(const std::optional<std::string>& folder)
{
    _settings.wishes.folder = folder;
    applyUserOptions(_settings);
}

void HapticScene::traverse(osg::NodeVisitor& visitor)
{
    if (visitor.getVisitorType() == osg::NodeVisitor::EVENT_VISITOR)
        if (osgGA::EventVisitor* event = visitor.asEventVisitor())
            if (_engine->follow(event->getActionAdapter()))
            {
                SceneKeys::addTo(event->getActionAdapter(), *_engine);
                showOnDisplayOfUser(event->getActionAdapter());
            }
    if (visitor.getVisitorType() == osg::NodeVisitor::UPDATE_VISITOR)
    {
        if (osgGA::GUIActionAdapter* view = _engine->followAbove(*this))
        {
            SceneKeys::addTo(view, *_engine);
            showOnDisplayOfUser(view);
        }
        // If only this node has requested the traversal, the rest of a large scene can be skipped.
        if (getNumChildrenRequiringUpdateTraversal() <= 1) return;
    }
    osg::Group::traverse(visitor);
}

osg::BoundingSphere HapticScene::computeBound() const
{
    _engine->noteBound();
    return osg::Group::computeBound();
}

void HapticScene::update(const osg::FrameStamp* frameStamp, const osg::Matrixd& world)
{
    if (_engine->rests(SceneRoot{this, world})) return;
    const unsigned int frame = frameStamp ? frameStamp->getFrameNumber() : 0;
    const double time_s = frameStamp ? frameStamp->getSimulationTime() : 0.0;
    _engine->update({{this, world}}, frame, 0.0, time_s);
}

void HapticScene::setHandSource(HandSource* source)
{
    _engine->lookNext();
    _engine->setHandSource(source);
}

HandSource* HapticScene::getHandSource() const
{
    return _engine->handSource();
}

void HapticScene::setDisplayTime(double steady_s)
{
    _engine->setDisplayTime(steady_s);
}

void HapticScene::setHeadSource(HeadSource* source)
{
    _engine->lookNext();
    _engine->setHeadSource(source);
}

HeadSource* HapticScene::getHeadSource() const
{
    return _engine->headSource();
}

bool HapticScene::getHead(Head& head) const
{
    return _engine->head(head);
}

void HapticScene::setTouchCallback(TouchCallback* callback)
{
    _engine->setTouchCallback(callback);
}

TouchCallback* HapticScene::getTouchCallback() const
{
    return _engine->touchCallback();
}

std::vector<Touch> HapticScene::getTouches() const
{
    return _engine->touches();
}

void HapticScene::setDeviceCallback(DeviceCallback* callback)
{
    _engine->setDeviceCallback(callback);
}

DeviceCallback* HapticScene::getDeviceCallback() const
{
    return _engine->deviceCallback();
}

void HapticScene::setMessageCallback(MessageCallback* callback)
{
    _engine->setMessageCallback(callback);
}

MessageCallback* HapticScene::getMessageCallback() const
{
    return _engine->messageCallback();
}

std::vector<HapticMessage> HapticScene::getActiveMessages() const
{
    return activeOf(getStatistics().told);
}

void HapticScene::clearMessages()
{
    _engine->clearMessages();
}

void HapticScene::setMuted(bool muted)
{
    _engine->setMuted(muted);
    notePropertyChange(); // for a scene around this one
}

bool HapticScene::getMuted() const
{
    return _engine->isMuted();
}

void HapticScene::setJoined(bool joined)
{
    _engine->setJoined(joined);
}

bool HapticScene::getJoined() const
{
    return _engine->isJoined();
}

void HapticScene::setRehearsed(bool rehearsed)
{
    _engine->setRehearsed(rehearsed);
}

bool HapticScene::getRehearsed() const
{
    return _engine->isRehearsed();
}

HapticSettings HapticScene::getGrantedSettings() const
{
    return _engine->grantedSettings();
}

void HapticScene::setUnmarkedProperty(const HapticProperty& property)
{
    _engine->setUnmarkedProperty(property);
}

std::vector<FoundObject> HapticScene::getFoundObjects() const
{
    return _engine->found();
}

void HapticScene::setObstacles(const std::vector<Obstacle>& obstacles)
{
    _engine->lookNext();
    _engine->setObstacles(obstacles);
}

const std::vector<Obstacle>& HapticScene::getObstacles() const
{
    return _engine->obstacles();
}

void HapticScene::setEars(const std::vector<osg::Vec3d>& places)
{
    _engine->lookNext();
    _engine->setEars(places);
}

const std::vector<osg::Vec3d>& HapticScene::getEars() const
{
    return _engine->ears();
}

void HapticScene::dirtyTags()
{
    _engine->dirtyTags();
}

void HapticScene::silence()
{
    _engine->silence();
}

HapticStatistics HapticScene::getStatistics() const
{
    return _engine->statistics();
}

osg::ref_ptr<const HapticField> HapticScene::getField() const
{
    return _engine->field();
}

osg::ref_ptr<const HapticField> HapticScene::waitForField(double timeout, std::string* why) const
{
    std::string error;
    const osg::ref_ptr<const HapticField> field = _engine->awaitField(timeout, error);
    if (why) *why = error;
    return field;
}

void HapticScene::setFieldCallback(FieldCallback* callback)
{
    _engine->setFieldCallback(callback);
}

FieldCallback* HapticScene::getFieldCallback() const
{
    return _engine->fieldCallback();
}

osg::ref_ptr<const HapticField> HapticScene::solve(std::string* why, const osg::Matrixd& world)
{
    std::string error;
    const osg::ref_ptr<const HapticField> field = _engine->solve({this, world}, error);
    if (why) *why = error;
    return field;
}

} // namespace osgMidair
