#include <osgMidair/HapticPoints>

#include <osg/BoundingBox>

#include <atomic>

namespace osgMidair
{

namespace
{

unsigned int nextCount()
{
    static std::atomic<unsigned int> count{0};
    return ++count;
}

} // namespace

// Found by its request for the event traversal, like a HapticSurface.
HapticPoints::HapticPoints() : _modified(nextCount())
{
    setNumChildrenRequiringEventTraversal(1);
}

HapticPoints::HapticPoints(const HapticPoints& other, const osg::CopyOp& copyop) :
    osg::Node(other, copyop),
    HapticPropertyHolder(other),
    _points(other._points),
    _pressures(other._pressures),
    _modified(other._modified),
    _touchCallback(other._touchCallback)
{
    setNumChildrenRequiringEventTraversal(1); // the base class doesn't copy this count
}

HapticPoints::~HapticPoints() = default;

void HapticPoints::setPoints(const std::vector<osg::Vec3d>& points,
                             const std::vector<double>& pressures)
{
    // Copies, because the arguments may be this node's own vectors.
    std::vector<osg::Vec3d> newPoints = points;
    std::vector<double> newPressures = pressures;
    _points.swap(newPoints);
    _pressures.swap(newPressures);
    _modified = nextCount();
    dirtyBound(); // so that a scene at rest also checks at once
}

osg::BoundingSphere HapticPoints::computeBound() const
{
    osg::BoundingBoxd box;
    for (const osg::Vec3d& point : _points)
        if (point.valid()) box.expandBy(point);
    if (!box.valid()) return {};
    return {osg::Vec3(box.center()), static_cast<float>(box.radius())};
}

} // namespace osgMidair
