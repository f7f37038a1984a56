#pragma once

#include "engine-bridge/bodies/RigidBodyStepper.h"

#include <osg/Callback>
#include <osg/Matrixd>
#include <osg/ref_ptr>

namespace midair::bridge
{

/// Update callback that lets a Bullet body drive an osg::MatrixTransform or
/// osg::PositionAttitudeTransform, and steps the world to the frame's simulation time on the way.
///
/// The body moves in world coordinates in metres; whatever transforms lie above the node are taken
/// out again. The body must outlive the callback. On any other node it only steps the world.
class RigidBodyPose : public osg::NodeCallback
{
public:
    /// \a stepper not null. \a unit_m: metres a scene unit, > 0. \a offset (row vectors, as OSG has
    /// it) goes from the node's own coordinates to the body's, in scene units: a scale, or a centre
    /// of mass that is not the model's origin; a PositionAttitudeTransform keeps its own scale and
    /// pivot and takes the offset's rotation and translation.
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
