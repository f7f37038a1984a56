#pragma once

#include <osg/Matrixd>

namespace osg
{
class NodeVisitor;
class Transform;
} // namespace osg

namespace midair::bridge
{

/// Returns true for a transform that turns or scales with the camera on screen
/// (osg::AutoTransform).
bool followsCamera(const osg::Transform& transform);

/// The transform's own matrix, from its children to its parent, without what depends on a camera: a
/// transform that follows the camera counts as not turned and not scaled by it. Only for relative
/// reference frames.
osg::Matrixd cameraFreeMatrix(osg::Transform& transform, osg::NodeVisitor* visitor);

} // namespace midair::bridge
