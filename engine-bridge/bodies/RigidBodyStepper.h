#pragma once

#include <osg/Callback>
#include <osg/Matrixd>
#include <osg/Referenced>
#include <osg/ref_ptr>

#include <Eigen/Geometry>

#include <cstdint>
#include <string>
#include <vector>

class btDynamicsWorld;
class btRigidBody;

namespace midair::bridge
{

/// Options of a RigidBodyStepper; isValid() names a setting that is out of its range.
struct StepperOptions
{
    double step_s = 1.0 / 240.0; ///< > 0; length of a step
    /// >= step_s; the most time simulated in one call; the rest of a longer pause is dropped.
    double catchUp_s = 0.25;
    /// interpolate poses between the last two steps; false: the last step's
    bool interpolate = true;

    bool isValid(std::string* error = nullptr) const;
};

/// Steps a Bullet world by steps of equal length, so that the bodies' poses depend on the time
/// alone and not on when frames came. Bullet's own accumulator keeps the remainder in a float and
/// returns poses of a varying step.
///
/// The world belongs to the caller, must outlive the stepper and must not be stepped by other code.
/// To be used by one thread.
class RigidBodyStepper : public osg::Referenced
{
public:
    /// Throws std::invalid_argument if \a options are not valid.
    explicit RigidBodyStepper(btDynamicsWorld& world, const StepperOptions& options = {});

    /// Steps the world until less than one step is left to \a time_s. The first call sets the
    /// origin of time. Calls with the same time do nothing, so several may be made per frame; a
    /// time before the last one becomes the new origin.
    void advanceTo(double time_s);

    /// The body's centre of mass and orientation at the last advanceTo(), metres; interpolated only
    /// for tracked bodies.
    Eigen::Isometry3d pose(const btRigidBody& body) const;

    /// Keeps the body's pose before each step, for interpolation, until untrack() was called as
    /// often as track().
    void track(const btRigidBody& body);
    void untrack(const btRigidBody& body);

    std::uint64_t steps() const { return _steps; }
    double dropped_s() const
    {
        return _dropped_s;
    } ///< time that was not simulated because of pauses

protected:
    ~RigidBodyStepper() override = default;

private:
    /// A body whose pose before the last step is kept.
    struct Tracked
    {
        const btRigidBody* body;
        Eigen::Isometry3d before; ///< pose before the last step
        int users = 0;
    };

    btDynamicsWorld& _world;
    StepperOptions _options;
    bool _begun = false;
    double _origin_s = 0.0; ///< time of step _originStep
    std::uint64_t _originStep = 0;
    std::uint64_t _steps = 0;
    double _time_s = 0.0;
    double _share = 0.0; ///< time since the last step over step_s
    double _dropped_s = 0.0;
    std::vector<Tracked> _tracked;
};

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
