#include "engine-bridge/bodies/RigidBodyPose.h"

#include <osgMidair/RigidBodyCallback>

namespace osgMidair
{

RigidBodyWorld::RigidBodyWorld(btDynamicsWorld& world, double step_s, double catchUp_s)
{
    midair::bridge::StepperOptions options;
    options.step_s = step_s;
    options.catchUp_s = catchUp_s;
    _stepper = new midair::bridge::RigidBodyStepper(world, options);
}

RigidBodyWorld::~RigidBodyWorld() = default;

std::uint64_t RigidBodyWorld::getNumSteps() const
{
    return _stepper->steps();
}

double RigidBodyWorld::getDroppedTime() const
{
    return _stepper->dropped_s();
}

RigidBodyCallback::RigidBodyCallback(RigidBodyWorld* world,
                                     const btRigidBody& body,
                                     double metresPerUnit,
                                     const osg::Matrixd& offset) :
    _world(world),
    _pose(new midair::bridge::RigidBodyPose(&world->stepper(), body, metresPerUnit, offset))
{
}

RigidBodyCallback::~RigidBodyCallback() = default;

void RigidBodyCallback::operator()(osg::Node* node, osg::NodeVisitor* visitor)
{
    (*_pose)(node, visitor); // which traverses, nested callbacks included
}

} // namespace osgMidair
