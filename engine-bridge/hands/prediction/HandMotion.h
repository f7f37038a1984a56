#pragma once

#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/prediction/MotionTrack.h"

#include <Eigen/Geometry>

#include <array>
#include <bitset>
#include <cstddef>
#include <memory>
#include <vector>

namespace midair::bridge
{

/// Follows one hand and predicts it as a palm that is rigid, six coordinates, and the turn of each
/// finger about its knuckle. All that moves turns and shifts, so that bones keep the lengths that
/// they were measured with. What of the palm isn't tracked is left out; of a hand without any of
/// the palm, all joints that are tracked move as one.
class HandMotion
{
public:
    /// A new measurement farther than this from the last one begins anew, as what the hand did in
    /// between isn't known.
    static constexpr double kLongestGap_s = 0.05;
    /// What is faster is another hand, or the tracker's error, where it is at the same time farther
    /// than kNearest_m away.
    static constexpr double kFastest_mps = 10.0;
    static constexpr double kNearest_m = 0.05;

    /// \a method: one that has a filter.
    explicit HandMotion(PredictionMethod method) : _method(method) {}

    /// What became of a measurement.
    enum Outcome
    {
        FOLLOWED,
        BEGUN, ///< anew: it is the first, or came after a gap, or other joints are tracked
        JUMPED ///< anew: it is too far from the last one
    };

    /// Takes \a hand, whose valid joints have finite positions, as it was seen at \a time_s.
    /// \a jump_m gets the way that it went if it JUMPED.
    Outcome update(double time_s, const Hand& hand, double& jump_m);

    /// Moves the measured joints, and gives each its sigma_m, to \a ahead_s (>= 0) after time_s().
    Hand predict(double ahead_s) const;

    /// Returns true if \a hand is what was measured last: the tracker has nothing newer.
    bool isLast(const Hand& hand) const;

    double time_s() const { return _time_s; } ///< of the last measurement

private:
    static constexpr int kFingers = 5;
    using Joints = std::bitset<HAND_JOINTS>;

    struct Finger
    {
        std::unique_ptr<MotionTrack> turn; ///< of the direction knuckle to tip; rad, palm's frame
        Joints tracked;
        Eigen::Vector3d direction = Eigen::Vector3d::UnitZ(); ///< unit, in the palm's frame
    };

    static Joints rigidJoints(const Hand& hand);
    void begin(double time_s, const Hand& hand);
    void followFingers(double time_s);
    Eigen::Quaterniond fittedTurn(const Hand& hand) const;
    Eigen::Vector3d middle(const Hand& hand) const;
    void followFinger(int which, double time_s);
    void turnFinger(int which, double ahead_s, Hand& hand) const;

    PredictionMethod _method;
    double _time_s = 0.0;
    Hand _last;
    Joints _rigid; ///< the joints of _last that say where the palm is
    std::unique_ptr<MotionTrack> _place;
    std::unique_ptr<MotionTrack> _turn;                          ///< null: it can't be seen
    Eigen::Matrix3Xd _shape;                                     ///< _rigid where it was begun
    Eigen::Quaterniond _turned = Eigen::Quaterniond::Identity(); ///< since then
    std::array<Finger, kFingers> _fingers;
};

} // namespace midair::bridge
