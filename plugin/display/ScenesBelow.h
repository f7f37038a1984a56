#pragma once

#include <osgMidair/HapticScene>

#include <osg/NodeVisitor>

#include <vector>

namespace osgMidair
{

/// Collects the outermost haptic scenes of a graph, shown or hidden.
class ScenesBelow : public osg::NodeVisitor
{
public:
    explicit ScenesBelow(osg::Node& root) : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN)
    {
        root.accept(*this);
    }
    void apply(osg::Group& node) override
    {
        if (auto* scene = dynamic_cast<HapticScene*>(&node))
            found.push_back(scene);
        else
            traverse(node);
    }

    std::vector<HapticScene*> found;
};

} // namespace osgMidair
