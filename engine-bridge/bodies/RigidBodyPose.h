#pragma once

#include "engine-bridge/bodies/RigidBodyStepper.h"

#include <osg/Callback>
#include <osg/Matrixd>
#include <osg/ref_ptr>

namespace midair::bridge
{

/// Update callback with which a Bullet body drives an osg::MatrixTransform or
/// osg::PositionAttitudeTransform. It also steps the world to the frame's simulation time.
///
/// The body moves in world coordinates in metres; the callback cancels the transforms above the
/// node. The body must outlive the callback. On any other node it only steps the world.
class RigidBodyPose : public osg::NodeCallback
{
public:
    /// \a stepper must not be null. \a unit_m: metres per scene unit, > 0. \a offset (for row
    /// vectors, as in OSG) maps the node's own coordinates to the body's, in scene units: a scale,
    /// or a centre of mass that is not the model's origin. A PositionAttitudeTransform keeps its
    /// own scale and pivot and uses only the offset's rotation and translation.
    RigidBodyPose(RigidBodyStepper* stepper,
                  const btRigidBody& body,
                  double unit_m = 1.0,
                  const osg::Matrixd& offset = osg::Matrixd());

    void operator()(osg::Node* node, osg::NodeVisitor* visitor) override;

protected:
    ~RigidBodyPose() override;

private:
    osg::ref_ptr<RigidBodyStepper> _stepper;
    const btRigidBody& _body;
    double _unit_m;
    osg::Matrixd _offset;
};

} // namespace midair::bridge
