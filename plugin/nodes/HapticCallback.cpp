#include "plugin/engine/HapticEngine.h"

#include <osgMidair/HapticCallback>

#include <osgGA/EventVisitor>

namespace osgMidair
{

HapticCallback::HapticCallback(const HapticSettings& settings) : _settings(settings) {}

HapticCallback::~HapticCallback() = default;

void HapticCallback::operator()(osg::Node* node, osg::NodeVisitor* visitor)
{
    if (osgGA::EventVisitor* event = visitor->asEventVisitor())
    {
        if (!_engine || _engine->root() != node)
            _engine = new HapticEngine(*node, _settings, OwnerKind::CALLBACK);
        _engine->follow(event->getActionAdapter());
    }
    traverse(node, visitor);
}

HapticStatistics HapticCallback::getStatistics() const
{
    return _engine ? _engine->statistics() : HapticStatistics();
}

} // namespace osgMidair
