#pragma once

#include <osgMidair/HapticScene>

#include <osg/NodeVisitor>

#include <algorithm>
#include <vector>

namespace midair::samples
{

/// Returns the HapticScenes at and below \a root without duplicates. \a alsoHidden includes those
/// below nodes with mask 0.
inline std::vector<osgMidair::HapticScene*> scenesBelow(osg::Node& root, bool alsoHidden)
{
    class Finder : public osg::NodeVisitor
    {
    public:
        explicit Finder(bool alsoHidden) : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN)
        {
            if (alsoHidden) setNodeMaskOverride(~0U);
        }
        void apply(osg::Group& group) override
        {
            auto* scene = dynamic_cast<osgMidair::HapticScene*>(&group);
            if (scene && std::count(found.begin(), found.end(), scene) == 0) found.push_back(scene);
            traverse(group);
        }
        std::vector<osgMidair::HapticScene*> found;
    };
    Finder finder(alsoHidden);
    root.accept(finder);
    return finder.found;
}

} // namespace midair::samples
