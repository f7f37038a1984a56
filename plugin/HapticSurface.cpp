#include <osgMidair/HapticSurface>

#include <osg/Notify>

namespace osgMidair
{

HapticSurface::HapticSurface() = default;

HapticSurface::HapticSurface(osg::Node* child)
{
    addChild(child);
}

HapticSurface::HapticSurface(const HapticSurface& other, const osg::CopyOp& copyop) :
    osg::Group(other, copyop),
    _property(other._property),
    _touchCallback(other._touchCallback)
{
}

HapticSurface::~HapticSurface() = default;

void HapticSurface::setFormatVersion(int version)
{
    if (version > kFormatVersion)
        OSG_WARN << "osgMidair: a HapticSurface of format version " << version
                 << " was written by a newer kit; this one knows version " << kFormatVersion
                 << " and may lose properties" << std::endl;
}

} // namespace osgMidair
