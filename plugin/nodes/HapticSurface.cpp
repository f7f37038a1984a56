#include <osgMidair/HapticSurface>

namespace osgMidair
{

// The collecting visitor finds haptic nodes by their request for the event traversal, without
// walking the whole scene.
HapticSurface::HapticSurface()
{
    setNumChildrenRequiringEventTraversal(1);
}

HapticSurface::HapticSurface(osg::Node* child) : HapticSurface()
{
    addChild(child);
}

HapticSurface::HapticSurface(const HapticSurface& other, const osg::CopyOp& copyop) :
    osg::Group(other, copyop),
    HapticPropertyHolder(other),
    _touchCallback(other._touchCallback)
{
    // The base class doesn't copy this count but counts the children again.
    setNumChildrenRequiringEventTraversal(getNumChildrenRequiringEventTraversal() + 1);
}

HapticSurface::~HapticSurface() = default;

// The surface handles no events itself, so the traversal goes on only if a node below requested it.
void HapticSurface::traverse(osg::NodeVisitor& visitor)
{
    const bool isEvent = visitor.getVisitorType() == osg::NodeVisitor::EVENT_VISITOR;
    if (isEvent && getNumChildrenRequiringEventTraversal() <= 1) return;
    osg::Group::traverse(visitor);
}

} // namespace osgMidair
