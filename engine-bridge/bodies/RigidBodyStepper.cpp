#include "engine-bridge/bodies/RigidBodyStepper.h"

#include "engine-bridge/scene/Convert.h"
#include "haptics/base/text/Range.h"

#include <osg/FrameStamp>
#include <osg/MatrixTransform>
#include <osg/NodeVisitor>
#include <osg/PositionAttitudeTransform>
#include <osg/Transform>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <stdexcept>

#include <BulletDynamics/Dynamics/btDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

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

Eigen::Isometry3d toEigen(const btTransform& transform)
{
    const btQuaternion q = transform.getRotation();
    const btVector3& t = transform.getOrigin();
    Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
    result.linear() =
        Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()).normalized().toRotationMatrix();
    result.translation() = Eigen::Vector3d(t.x(), t.y(), t.z());
    return result;
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

bool StepperOptions::isValid(std::string* error) const
{
    return midair::base::RangeCheck("StepperOptions: ")
        .above("step_s", step_s, 0.0)
        .atLeast("catchUp_s", catchUp_s, step_s)
        .passed(error);
}

RigidBodyStepper::RigidBodyStepper(btDynamicsWorld& world, const StepperOptions& options) :
    _world(world),
    _options(options)
{
    std::string error;
    if (!options.isValid(&error)) throw std::invalid_argument(error);
}

void RigidBodyStepper::advanceTo(double time_s)
{
    if (!std::isfinite(time_s) || (_begun && time_s == _time_s)) return;
    if (!_begun || time_s < _time_s)
    {
        _begun = true;
        _origin_s = time_s - _share * _options.step_s;
        _originStep = _steps;
        _time_s = time_s;
        return;
    }
    _time_s = time_s;
    // Counts time from the origin instead of summing frame times, so that rounding can't move a
    // step from one frame to the next.
    double elapsed = (time_s - _origin_s) / _options.step_s + 1e-9;
    double due = std::floor(elapsed) - static_cast<double>(_steps - _originStep);
    const double most = std::floor(_options.catchUp_s / _options.step_s + 1e-9);
    if (due > most)
    {
        const double dropped = due - most;
        _dropped_s += dropped * _options.step_s;
        _origin_s += dropped * _options.step_s;
        elapsed -= dropped;
        due = most;
    }
    for (auto left = static_cast<std::int64_t>(due); left > 0; --left)
    {
        for (Tracked& tracked : _tracked)
            tracked.before = toEigen(tracked.body->getWorldTransform());
        _world.stepSimulation(static_cast<btScalar>(_options.step_s),
                              0); // 0: one step of just that length
        ++_steps;
    }
    _share = std::clamp(elapsed - std::floor(elapsed), 0.0, 1.0);
}

Eigen::Isometry3d RigidBodyStepper::pose(const btRigidBody& body) const
{
    Eigen::Isometry3d now = toEigen(body.getWorldTransform());
    const auto known = std::find_if(_tracked.begin(),
                                    _tracked.end(),
                                    [&](const Tracked& tracked) { return tracked.body == &body; });
    if (!_options.interpolate || known == _tracked.end()) return now;
    const Eigen::Quaterniond a(known->before.linear());
    const Eigen::Quaterniond b(now.linear());
    Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
    result.linear() = a.slerp(_share, b).toRotationMatrix();
    result.translation() =
        (1.0 - _share) * known->before.translation() + _share * now.translation();
    return result;
}

void RigidBodyStepper::track(const btRigidBody& body)
{
    for (Tracked& tracked : _tracked)
        if (tracked.body == &body)
        {
            ++tracked.users;
            return;
        }
    _tracked.push_back({&body, toEigen(body.getWorldTransform()), 1});
}

void RigidBodyStepper::untrack(const btRigidBody& body)
{
    for (std::size_t i = 0; i < _tracked.size(); ++i)
        if (_tracked[i].body == &body && --_tracked[i].users == 0)
        {
            _tracked.erase(_tracked.begin() + static_cast<std::ptrdiff_t>(i));
            return;
        }
}

} // namespace midair::bridge
