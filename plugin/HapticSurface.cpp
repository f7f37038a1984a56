#include <osgMidair/HapticSurface>

#include <osg/Notify>

namespace osgMidair
{

// Asking for the event traversal is how the collecting visitor finds haptic nodes without walking the whole scene.
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
    _property(other._property),
    _touchCallback(other._touchCallback)
{
    // Not copied by the base class, which counts the children anew.
    setNumChildrenRequiringEventTraversal(getNumChildrenRequiringEventTraversal() + 1);
}

HapticSurface::~HapticSurface() = default;

void HapticSurface::setFormatVersion(int version)
{
    _readVersion = version;
    if (version > kFormatVersion)
        OSG_WARN << "osgMidair: a HapticSurface of format version " << version
                 << " was written by a newer kit; this one knows version " << kFormatVersion
                 << " and may lose properties" << std::endl;
}

} // namespace osgMidair
