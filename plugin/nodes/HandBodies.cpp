#include "engine-bridge/bodies/HandBodies.h"

#include "engine-bridge/bodies/RigidBodyStepper.h"
#include "haptics/base/ThrownBy.h"
#include "plugin/engine/HapticEngine.h"
#include "plugin/engine/SceneAccess.h"
#include "plugin/hands/KitHands.h"
#include "plugin/settings/Grants.h"

#include <osgMidair/HandBodies>
#include <osgMidair/HapticScene>
#include <osgMidair/RigidBodyCallback>

#include <osg/NodeVisitor>
#include <osg/Notify>
#include <osg/observer_ptr>

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

constexpr double kStep_s = 1.0 / 240.0; // as a RigidBodyWorld's

} // namespace

struct HandBodies::Part
{
    Part(btDiscreteDynamicsWorld& world, double length_s) :
        bodies(std::make_shared<midair::bridge::HandBodies>(world)),
        step_s(isStep(length_s) ? length_s : kStep_s)
    {
    }

    static bool isStep(double length_s) { return length_s >= 0.0 && std::isfinite(length_s); }

    /// To the scene if there is one, else to OSG.
    void say(midair::base::MessageCode code, const std::string& what) const
    {
        osg::ref_ptr<HapticScene> itsScene;
        if (scene.lock(itsScene))
            SceneAccess::engine(*itsScene).say({code, what});
        else
            OSG_WARN << "osgMidair: " << printable(what) << std::endl;
    }

    /// Warns of an invalid step.
    void check(double length_s) const
    {
        if (isStep(length_s)) return;
        say(midair::base::MessageCode::SETTINGS_INVALID,
            fmt::format("the step of a HandBodies is {:g} s, should be 0 or more; 1/240 s is used",
                        length_s));
    }

    /// Stores the hands at \a time in frame. An exception of the source is logged once; then there
    /// are no hands.
    void ask(double time)
    {
        frame.hands.clear();
        const std::shared_ptr<midair::bridge::HandSource> itsSource = current();
        bool any = false;
        const std::string thrown =
            midair::base::thrownBy([&] { any = itsSource && itsSource->frameAt(time, frame); });
        if (!any || !thrown.empty()) frame.hands.clear();
        frame.time_s = time;
        if (thrown.empty() || thrown == told) return;
        told = thrown;
        say(midair::base::MessageCode::HANDS_THREW,
            "the hand source of a HandBodies has thrown " + thrown +
                ": there are no hands while it does");
    }

    /// Returns the source in use; null: none.
    std::shared_ptr<midair::bridge::HandSource> current() const
    {
        osg::ref_ptr<HapticScene> itsScene;
        if (scene.lock(itsScene)) return SceneAccess::engine(*itsScene).hands().active();
        return source;
    }

    const std::shared_ptr<midair::bridge::HandBodies> bodies;
    const double step_s;
    std::shared_ptr<midair::bridge::HandSource> source;
    osg::observer_ptr<HapticScene> scene;
    midair::bridge::HandFrame frame;
    std::string told; ///< the source's last exception
    double time_s = 0.0;
};

HandBodies::HandBodies(btDiscreteDynamicsWorld& world, HandSource* source, double step_s) :
    _part(std::make_unique<Part>(world, step_s))
{
    if (source) _part->source = std::make_shared<KitHands>(source);
    _part->check(step_s);
}

HandBodies::HandBodies(btDiscreteDynamicsWorld& world, HapticScene* scene, double step_s) :
    _part(std::make_unique<Part>(world, step_s))
{
    _part->scene = scene;
    if (scene) SceneAccess::engine(*scene).addBodies(_part->bodies);
    _part->check(step_s);
}

HandBodies::~HandBodies() = default;

void HandBodies::update(double time)
{
    _part->ask(time);
    for (midair::bridge::Hand& hand : _part->frame.hands)
        midair::bridge::leaveOutImpossible(hand);
    constexpr double kMost = 240.0; // steps of a frame, for subdividing a motion
    const double steps = _part->step_s > 0.0 ? (time - _part->time_s) / _part->step_s : 1.0;
    _part->time_s = time;
    _part->bodies->update(_part->frame,
                          static_cast<int>(std::clamp(std::round(steps), 1.0, kMost)));
}

void HandBodies::operator()(osg::Node* node, osg::NodeVisitor* visitor)
{
    if (visitor->getFrameStamp()) update(visitor->getFrameStamp()->getSimulationTime());
    traverse(node, visitor);
}

int HandBodies::getNumBodies() const
{
    return _part->bodies->count();
}

bool HandBodies::getBone(const btCollisionObject& object, int& hand, int& bone) const
{
    return _part->bodies->find(object, hand, bone);
}

struct RigidBodyWorld::Stepper
{
    osg::ref_ptr<midair::bridge::RigidBodyStepper> stepper;
};

struct RigidBodyCallback::Pose
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
