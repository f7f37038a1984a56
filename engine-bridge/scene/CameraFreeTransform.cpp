#include "engine-bridge/scene/CameraFreeTransform.h"

#include <osg/AutoTransform>

namespace midair::bridge
{

bool followsCamera(const osg::Transform& transform)
{
    const auto* automatic = dynamic_cast<const osg::AutoTransform*>(&transform);
    return automatic && (automatic->getAutoRotateMode() != osg::AutoTransform::NO_ROTATION ||
                         automatic->getAutoScaleToScreen());
}

osg::Matrixd cameraFreeMatrix(osg::Transform& transform, osg::NodeVisitor* visitor)
{
    osg::Matrixd matrix;
    if (!followsCamera(transform))
    {
        transform.computeLocalToWorldMatrix(matrix, visitor);
        return matrix;
    }
    // Left out: rotation and scale that the last cull traversal set.
    const auto& automatic = static_cast<const osg::AutoTransform&>(transform);
    matrix.makeTranslate(-automatic.getPivotPoint());
    if (!automatic.getAutoScaleToScreen()) matrix.postMultScale(automatic.getScale());
    if (automatic.getAutoRotateMode() == osg::AutoTransform::NO_ROTATION)
        matrix.postMultRotate(automatic.getRotation());
    matrix.postMultTranslate(automatic.getPosition());
    return matrix;
}

} // namespace midair::bridge
