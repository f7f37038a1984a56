#pragma once

#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/prediction/MotionTrack.h"

#include <Eigen/Geometry>

#include <array>
#include <bitset>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Tracks one hand and predicts it as a rigid palm, with six coordinates, and the rotation of each
/// finger around its knuckle. Only rotations and translations are applied, so that bones keep their
/// measured lengths. Untracked joints of the palm are ignored; without any of the palm, all tracked
/// joints move as one.
class HandMotion
{
public:
    /// After a gap longer than this prediction starts again, because the motion in between is
    /// unknown.
    static constexpr double kLongestGap_s = 0.05;
    /// A faster motion over more than kNearest_m is another hand, or an error of the tracker.
    static constexpr double kFastest_mps = 10.0;
    static constexpr double kNearest_m = 0.05;

    /// \a method: one with a filter.
    explicit HandMotion(PredictionMethod method) : _method(method) {}

    /// Result of a measurement.
    enum Outcome
    {
        FOLLOWED,
        BEGUN, ///< restarted: the first one, after a gap, or with other tracked joints
        JUMPED ///< restarted: too far from the last one
    };

    /// Adds \a hand, whose valid joints have finite positions, as seen at \a time_s. \a jump_m
    /// receives the distance if it JUMPED.
    Outcome update(double time_s, const Hand& hand, double& jump_m);

    /// Predicts the measured joints \a ahead_s (>= 0) after time_s(), and sets their sigma_m.
    Hand predict(double ahead_s) const;

    /// Returns true if \a hand equals the last measurement: the tracker has nothing newer.
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
    Eigen::Matrix3Xd shapeOf(const Hand& hand) const;
    Eigen::Quaterniond fittedTurn(const Hand& hand) const;
    Eigen::Vector3d middle(const Hand& hand) const;
    void followFinger(int which, double time_s);
    void turnFinger(int which, double ahead_s, Hand& hand) const;

    PredictionMethod _method;
    double _time_s = 0.0;
    Hand _last;
    Joints _rigid; ///< the joints of _last that determine the palm
    std::unique_ptr<MotionTrack> _place;
    std::unique_ptr<MotionTrack> _turn;                          ///< null: not measurable
    Eigen::Matrix3Xd _shape;                                     ///< _rigid at the start
    Eigen::Quaterniond _turned = Eigen::Quaterniond::Identity(); ///< since the start
    std::array<Finger, kFingers> _fingers;
};

/// Predicts hands to the time when the sound for them arrives. A hand that can't be predicted
/// (positions that aren't finite, a jump, too few measurements) stays where it was seen, with a
/// matching sigma_m; the others are predicted. To be used by one thread.
class HandPredictor
{
public:
    /// Longest prediction, s; longer ones are clamped.
    static constexpr double kFarthest_s = 0.25;
    /// Hand::id of a palm that represents a head, for messages.
    static constexpr int kHead = -1000;

    /// Sets the prediction method; OFF, the default, leaves frames unchanged. With TRACKER the
    /// joints, which the source has predicted, only get their sigma_m. A change of method forgets
    /// all hands.
    void setMethod(PredictionMethod method);
    PredictionMethod method() const { return _method; }

    /// Predicts the joints of \a frame \a horizon_s after its time, and sets their sigma_m. The
    /// time is on the clock of the hands' motion; a frame with an unchanged hand has no new
    /// measurement of it. A horizon below 0 or NaN leaves all hands where they were seen.
    void predict(HandFrame& frame, double horizon_s);

    /// Returns new messages for the user: for each hand, each kind of problem once per method.
    std::vector<std::string> takeMessages();

    /// Longest prediction in the last frame, s, from when the hand was seen; 0: none.
    double ahead_s() const { return _ahead_s; }

private:
    enum Trouble
    {
        NO_NUMBER = 1,
        JUMP = 2,
        NO_HORIZON = 4,
        FAR_HORIZON = 8,
        TWICE = 16
    };

    bool predictHand(double time_s, double horizon_s, Hand& hand);
    void move(double time_s, double target_s, Hand& hand);
    bool isUsable(const Hand& hand, double horizon_s);
    void say(int hand, Trouble trouble, const std::string& what);
    void dropLost(double time_s, const std::vector<int>& seen);

    PredictionMethod _method = PredictionMethod::OFF;
    std::map<int, HandMotion> _hands; ///< by Hand::id
    std::map<int, unsigned> _told;    ///< reported problems by Hand::id
    std::vector<std::string> _messages;
    double _ahead_s = 0.0;
};

} // namespace midair::bridge
