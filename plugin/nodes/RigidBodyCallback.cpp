#include "engine-bridge/bodies/RigidBodyPose.h"
#include "plugin/settings/ForTests.h"

#include <osgMidair/RigidBodyCallback>

namespace osgMidair
{

struct OSGMIDAIR_NO_EXPORT RigidBodyWorld::Stepper
{
    osg::ref_ptr<midair::bridge::RigidBodyStepper> stepper;
};

struct OSGMIDAIR_NO_EXPORT RigidBodyCallback::Pose
{
    osg::ref_ptr<midair::bridge::RigidBodyPose> pose;
};

RigidBodyWorld::RigidBodyWorld(btDynamicsWorld& world, double step_s, double catchUp_s)
{
    midair::bridge::StepperOptions options;
    options.step_s = step_s;
    options.catchUp_s = catchUp_s;
    _stepper =
        std::make_unique<Stepper>(Stepper{new midair::bridge::RigidBodyStepper(world, options)});
}

RigidBodyWorld::~RigidBodyWorld() = default;

std::uint64_t RigidBodyWorld::getNumSteps() const
{
    return _stepper->stepper->steps();
}

double RigidBodyWorld::getDroppedTime() const
{
    return _stepper->stepper->dropped_s();
}

RigidBodyCallback::RigidBodyCallback(RigidBodyWorld* world,
                                     const btRigidBody& body,
                                     double metresPerUnit,
                                     const osg::Matrixd& offset) :
    _world(world),
    _pose(std::make_unique<Pose>(Pose{
        new midair::bridge::RigidBodyPose(world->_stepper->stepper, body, metresPerUnit, offset)}))
{
}

RigidBodyCallback::~RigidBodyCallback() = default;

void RigidBodyCallback::operator()(osg::Node* node, osg::NodeVisitor* visitor)
{
    (*_pose->pose)(node, visitor); // this also traverses, with nested callbacks
}

} // namespace osgMidair
