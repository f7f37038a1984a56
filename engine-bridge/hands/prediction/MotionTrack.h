#pragma once

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <cstddef>
#include <memory>

namespace midair::bridge
{

/// Who predicts the hands, and how.
enum class PredictionMethod
{
    OFF,        ///< nobody: hands are where they were last seen
    TRACKER,    ///< the source is asked for the hands of a later time, if it can tell them
    ALPHA_BETA, ///< constant speed, with the gains of Kalata
    KALMAN,     ///< constant acceleration, with the gains of Kalman
    ONE_EURO    ///< smoothed more when slow, then moved on at the smoothed speed
};

/// What a filter assumes. The unit u of a coordinate is m for a place and rad for a turn.
struct MotionNoise
{
    double measured = 1e-3; ///< u, > 0; standard deviation of a measured coordinate
    /// u/s^2, > 0; standard deviation of the acceleration that alpha-beta and one euro don't follow
    double acceleration = 5.0;
    double jerk = 50.0; ///< u/s^3, > 0; of the jerk that the Kalman filter doesn't follow
};

/// The defaults for coordinates whose noise is \a measured (u, > 0): all in the same ratios, so
/// that the gains of a filter don't depend on the unit. 50 m/s^3 and 5 m/s^2 at 1 mm fit a hand
/// that reaches 0.3 m in 0.6 s.
MotionNoise motionNoise(double measured);

/// A coordinate at a later time.
struct PredictedMotion
{
    double value = 0.0; ///< u
    double noise = 0.0; ///< u, > 0; standard deviation that the measurements' noise makes
    double lag = 0.0;   ///< u, >= 0; error that the assumed acceleration or jerk makes if it lasts

    double sigma() const { return std::sqrt(noise * noise + lag * lag); }
};

/// Follows one coordinate of something that moves, and predicts it. Times of measurements need not
/// be equally spaced. To be used by one thread. Values have to be finite; they are the caller's to
/// check.
class MotionFilter
{
public:
    virtual ~MotionFilter() = default;

    /// Forgets all, and begins at \a value.
    virtual void restart(double value) = 0;

    /// Takes the measurement \a value, \a interval_s (> 0) after the last one.
    virtual void update(double interval_s, double value) = 0;

    /// The coordinate \a ahead_s (>= 0) after the last measurement.
    virtual PredictedMotion predict(double ahead_s) const = 0;
};

/// Makes the filter of \a method; null for OFF and TRACKER, which have none.
std::unique_ptr<MotionFilter> makeMotionFilter(PredictionMethod method, const MotionNoise& noise);

/// Gains of an alpha-beta filter.
struct AlphaBetaGains
{
    double alpha = 1.0;
    double beta = 1.0; ///< per interval: the speed's correction is beta / interval
};

/// Gains for measurements each \a interval_s (> 0): with Lambda = s_a T^2 / s_m and
/// r = (4 + Lambda - sqrt(8 Lambda + Lambda^2)) / 4, alpha = 1 - r^2 and
/// beta = 2 (2 - alpha) - 4 sqrt(1 - alpha) (P. R. Kalata, "The tracking index", IEEE Trans.
/// Aerospace and Electronic Systems 20, 1984).
AlphaBetaGains kalataGains(double interval_s, const MotionNoise& noise);

/// How far something has gone since it was last measured.
struct PredictedShift
{
    Eigen::Vector3d shift = Eigen::Vector3d::Zero(); ///< u, to be added to the last measurement
    double sigma = 0.0;                              ///< u, > 0; expected error of the place then
};

/// Follows three coordinates that belong together, and predicts them less and less as they come to
/// rest: a prediction multiplies noise, and overshoots what has stopped.
class MotionTrack
{
public:
    /// What moves slower than this (m/s) isn't predicted at all, and what is faster than the second
    /// wholly; in between it is by a share that rises with the pace: half of it at 0.05 m/s, which
    /// is 3.5 mm in 70 ms. Lower ones let the noise of a tracker that sees each joint apart
    /// through.
    static constexpr double kRest = 0.035;
    static constexpr double kMoving = 0.07;
    /// The pace is that between the means of the two halves of the last measurements: those of this
    /// time, and kLeast at least.
    static constexpr double kWindow_s = 0.1;
    static constexpr std::size_t kLeast = 4;
    /// What is this fast (m/s) has the accelerations that MotionNoise assumes; what is slower has
    /// less, in proportion, as reaches of one duration have, but a tenth at least.
    static constexpr double kReach = 0.5;
    static constexpr double kLeastReach = 0.1;
    /// The speed (m/s) that something may have whose pace isn't known yet, for its sigma.
    static constexpr double kUnknown = 1.0;

    /// \a measured: noise of a coordinate, u (m or rad), > 0. \a metresPerUnit: what a u comes to
    /// on the skin; 1 for places, for turns the lever's length in m. \a method: one that has a
    /// filter.
    MotionTrack(PredictionMethod method, double measured, double metresPerUnit);

    /// Forgets all but \a place, and begins with it at \a time_s.
    void restart(double time_s, const Eigen::Vector3d& place);

    /// Takes the measurement \a place at \a time_s, which has to be after the last one's.
    void update(double time_s, const Eigen::Vector3d& place);

    /// The way from the last measurement to the place \a ahead_s (>= 0) after it.
    PredictedShift predict(double ahead_s) const;

    /// The skin's speed, m/s. Only for kLeast measurements or more: isKnown().
    double pace() const;
    bool isKnown() const { return _count >= kLeast; }
    const Eigen::Vector3d& place() const { return _recent[_newest].place; }
    double time_s() const { return _recent[_newest].time_s; }

private:
    static constexpr std::size_t kMost = 64;

    struct Measurement
    {
        double time_s = 0.0;
        Eigen::Vector3d place = Eigen::Vector3d::Zero();
    };

    /// The measurement \a back before the newest.
    const Measurement& before(std::size_t back) const
    {
        return _recent[(_newest + kMost - back) % kMost];
    }

    std::array<std::unique_ptr<MotionFilter>, 3> _filters;
    double _measured;
    double _metresPerUnit;
    std::array<Measurement, kMost> _recent; ///< a ring
    std::size_t _newest = 0;
    std::size_t _count = 0;
};

} // namespace midair::bridge
