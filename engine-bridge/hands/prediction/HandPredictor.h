#pragma once

#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/prediction/HandMotion.h"

#include <map>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Moves hands to where they will be when the sound that is being made for them arrives. A hand
/// that can't be predicted (its joints are no numbers, it has jumped, it has been seen too few
/// times) stays where it was seen, with a sigma_m that says so; the others go on. To be used by one
/// thread.
class HandPredictor
{
public:
    /// The farthest that hands are predicted, s; what is asked beyond is cut.
    static constexpr double kFarthest_s = 0.25;

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
