#pragma once

#include <osg/Referenced>

#include <Eigen/Geometry>

#include <cstdint>
#include <string>
#include <vector>

class btDynamicsWorld;
class btRigidBody;

namespace midair::bridge
{

/// How a RigidBodyStepper steps; isValid() names the first setting that is out of its range.
struct StepperOptions
{
    double step_s = 1.0 / 240.0; ///< > 0
    /// >= step_s; of a pause longer than this (s) the rest is dropped instead of simulated.
    double catchUp_s = 0.25;
    bool interpolate = true; ///< poses between the last two steps; false: of the last step

    bool isValid(std::string* error = nullptr) const;
};

/// Steps a Bullet world by whole steps of equal length, so that where bodies are depends on the
/// time alone and not on when frames came. Bullet's own accumulator keeps the remainder in a float
/// and hands poses of a varying step out.
///
/// The world belongs to the caller, must outlive the stepper and must not be stepped by anyone
/// else. One thread.
class RigidBodyStepper : public osg::Referenced
{
public:
    /// Throws std::invalid_argument where \a options are wrong.
    explicit RigidBodyStepper(btDynamicsWorld& world, const StepperOptions& options = {});

    /// Steps until the last step is at most one step before \a time_s. The first call sets where
    /// time begins. Calls with the same time do nothing, so several may be made in a frame; a time
    /// before the last one begins anew from there.
    void advanceTo(double time_s);

    /// The body's centre of mass and orientation at the last advanceTo(), metres; between steps
    /// only for tracked bodies.
    Eigen::Isometry3d pose(const btRigidBody& body) const;

    /// Remembers the body's pose before each step until it is untracked as often as it was tracked.
    void track(const btRigidBody& body);
    void untrack(const btRigidBody& body);

    std::uint64_t steps() const { return _steps; }
    double dropped_s() const
    {
        return _dropped_s;
    } ///< time that was not simulated because of pauses
    const StepperOptions& options() const { return _options; }

protected:
    ~RigidBodyStepper() override = default;

private:
    struct Tracked
    {
        const btRigidBody* body;
        Eigen::Isometry3d before; ///< the last step
        int users = 0;
    };

    btDynamicsWorld& _world;
    StepperOptions _options;
    bool _begun = false;
    double _origin_s = 0.0; ///< time of step _originStep
    std::uint64_t _originStep = 0;
    std::uint64_t _steps = 0;
    double _time_s = 0.0;
    double _share = 0.0; ///< of a step that has gone by since the last one
    double _dropped_s = 0.0;
    std::vector<Tracked> _tracked;
};

} // namespace midair::bridge
