#include "FollowViewer.h"
#include "HapticEngine.h"
#include "engine-bridge/HologramResult.h"
#include "haptics/Medium.h"

#include <osgMidair/HapticScene>

#include <osg/Notify>
#include <osgGA/EventVisitor>

namespace osgMidair
{

HapticScene::HapticScene() : _engine(std::make_unique<HapticEngine>())
{
    setNumChildrenRequiringEventTraversal(1);
}

HapticScene::HapticScene(const HapticScene& other, const osg::CopyOp& copyop) :
    osg::Group(other, copyop),
    _settings(other._settings),
    _engine(std::make_unique<HapticEngine>())
{
    // Not copied by the base class.
    setNumChildrenRequiringEventTraversal(getNumChildrenRequiringEventTraversal() + 1);
}

HapticScene::~HapticScene() = default;

void HapticScene::setFormatVersion(int version)
{
    if (version > kFormatVersion)
        OSG_WARN << "osgMidair: a HapticScene of format version " << version
                 << " was written by a newer kit; this one knows version " << kFormatVersion
                 << " and may lose properties" << std::endl;
}

void HapticScene::traverse(osg::NodeVisitor& visitor)
{
    if (visitor.getVisitorType() == osg::NodeVisitor::EVENT_VISITOR)
        if (osgGA::EventVisitor* event = visitor.asEventVisitor())
            if (auto operation = followViewerOf(event->getActionAdapter(), *this, _followers))
                _followers.emplace_back(operation);
    osg::Group::traverse(visitor);
}

void HapticScene::update(const osg::FrameStamp* frameStamp, const osg::Matrixd& world)
{
    _engine->update(*this, world, _settings, frameStamp ? frameStamp->getFrameNumber() : 0, 0.0);
}

void HapticScene::silence()
{
    _engine->silence();
}

std::shared_ptr<const midair::bridge::HologramResult> HapticScene::getLatestResult() const
{
    return _engine->latestResult();
}

HapticStatistics HapticScene::getStatistics() const
{
    return _engine->statistics();
}

std::shared_ptr<const midair::haptics::TransducerArray> HapticScene::getTransducerArray() const
{
    return _engine->array();
}

midair::haptics::Medium HapticScene::getMedium() const
{
    return _engine->medium();
}

} // namespace osgMidair
