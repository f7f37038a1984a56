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
    Eigen::Matrix3Xd shapeOf(const Hand& hand) const;
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

/// Moves hands to where they will be when the sound that is being made for them arrives. A hand
/// that can't be predicted (its joints are no numbers, it has jumped, it has been seen too few
/// times) stays where it was seen, with a sigma_m that says so; the others go on. To be used by one
/// thread.
class HandPredictor
{
public:
    /// The farthest that hands are predicted, s; what is asked beyond is cut.
    static constexpr double kFarthest_s = 0.25;
    /// Hand::id of a palm that stands for a head, which messages name so.
    static constexpr int kHead = -1000;

    /// Sets how hands are predicted; OFF, the default, leaves frames as they are. With TRACKER the
    /// joints, which the source has predicted, get their sigma_m only. Another method than before
    /// forgets all hands.
    void setMethod(PredictionMethod method);
    PredictionMethod method() const { return _method; }

    /// Moves the joints of \a frame to \a horizon_s after its time, and gives each its sigma_m. The
    /// time's clock is that of the hands' motion; a frame whose hand is as it was before has no new
    /// measurement of it. A horizon that is under 0 or no number leaves all hands where they were
    /// seen.
    void predict(HandFrame& frame, double horizon_s);

    /// Returns what the user should know that has happened since the last call: of each hand, each
    /// kind of trouble once as long as the method stays.
    std::vector<std::string> takeMessages();

    /// How far the hands of the last frame were predicted from when they were seen, s: the farthest
    /// of them; 0: none was.
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
    std::map<int, unsigned> _told;    ///< troubles by Hand::id
    std::vector<std::string> _messages;
    double _ahead_s = 0.0;
};

} // namespace midair::bridge
