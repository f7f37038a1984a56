#pragma once

#include <cmath>
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

} // namespace midair::bridge
