#include <osgMidair/HapticSurface>

#include <osg/Notify>

namespace osgMidair
{

// Asking for the event traversal is how the collecting visitor finds haptic nodes without walking
// the whole scene.
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
    // Not copied by the base class, which counts the children anew.
    setNumChildrenRequiringEventTraversal(getNumChildrenRequiringEventTraversal() + 1);
}

HapticSurface::~HapticSurface() = default;

// Nothing is done here for events: they go further down only where something else asked for them.
void HapticSurface::traverse(osg::NodeVisitor& visitor)
{
    const bool isEvent = visitor.getVisitorType() == osg::NodeVisitor::EVENT_VISITOR;
    if (isEvent && getNumChildrenRequiringEventTraversal() <= 1) return;
    osg::Group::traverse(visitor);
}

void HapticSurface::setFormatVersion(int version)
{
    _readVersion = version;
    if (version > kFormatVersion)
        OSG_WARN << "osgMidair: a HapticSurface of format version " << version
                 << " was written by a newer kit; this one knows version " << kFormatVersion
                 << " and may lose properties" << std::endl;
}

} // namespace osgMidair
