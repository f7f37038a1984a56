#pragma once

#include <osg/Node>
#include <osg/observer_ptr>

#include <string>

namespace osgMidair
{

/// HapticObject::origin of what the SceneCollector makes: the node that is felt and its path, for
/// whoever gets the field. Immutable; any thread may keep it.
struct FeltNode
{
    osg::observer_ptr<osg::Node> node;
    std::string path;
};

} // namespace osgMidair
