#include "engine-bridge/bodies/RigidBodyPose.h"

#include "engine-bridge/scene/Convert.h"

#include <osg/FrameStamp>
#include <osg/MatrixTransform>
#include <osg/NodeVisitor>
#include <osg/PositionAttitudeTransform>
#include <osg/Transform>

#include <cassert>

namespace midair::bridge
{

namespace
{

/// The matrix of the transforms above the node, on the path that the visitor took.
osg::Matrixd parentToWorld(const osg::NodeVisitor& visitor)
{
    osg::NodePath path = visitor.getNodePath();
    if (!path.empty()) path.pop_back();
    return osg::computeLocalToWorld(path);
}

} // namespace

RigidBodyPose::RigidBodyPose(RigidBodyStepper* stepper,
                             const btRigidBody& body,
                             double unit_m,
                             const osg::Matrixd& offset) :
    _stepper(stepper),
    _body(body),
    _unit_m(unit_m),
    _offset(offset)
{
    assert(stepper && unit_m > 0.0);
    _stepper->track(_body);
}

RigidBodyPose::~RigidBodyPose()
{
    _stepper->untrack(_body);
}

void RigidBodyPose::operator()(osg::Node* node, osg::NodeVisitor* visitor)
{
    if (const osg::FrameStamp* stamp = visitor->getFrameStamp())
        _stepper->advanceTo(stamp->getSimulationTime());
    const Eigen::Isometry3d pose = _stepper->pose(_body);
    osg::Matrixd world = toOsg(pose.matrix());
    world.setTrans(world.getTrans() / _unit_m);
    const osg::Matrixd local = _offset * world * osg::Matrixd::inverse(parentToWorld(*visitor));
    if (osg::Transform* transform = node->asTransform())
    {
        if (osg::MatrixTransform* matrix = transform->asMatrixTransform())
            matrix->setMatrix(local);
        else if (osg::PositionAttitudeTransform* placed = transform->asPositionAttitudeTransform())
        {
            placed->setPosition(local.getTrans());
            placed->setAttitude(local.getRotate());
        }
    }
    traverse(node, visitor);
}

} // namespace midair::bridge
