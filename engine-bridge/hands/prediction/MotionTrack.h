#pragma once

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <cstddef>
#include <memory>

namespace midair::bridge
{

/// Method of predicting hands.
enum class PredictionMethod
{
    OFF,        ///< none: hands are where they were last seen
    TRACKER,    ///< the source predicts them, if it can
    ALPHA_BETA, ///< constant speed, with Kalata's gains
    KALMAN,     ///< constant acceleration, with Kalman's gains
    ONE_EURO    ///< smoothed more when slow, then extrapolated at the smoothed speed
};

/// Assumptions of a filter. The unit u of a coordinate is m for a position and rad for a rotation.
struct MotionNoise
{
    double measured = 1e-3; ///< u, > 0; standard deviation of a measured coordinate
    /// u/s^2, > 0; standard deviation of the acceleration that alpha-beta and one euro don't model
    double acceleration = 5.0;
    double jerk = 50.0; ///< u/s^3, > 0; of the jerk that the Kalman filter doesn't model
};

/// Returns the defaults for coordinates with the noise \a measured (u, > 0): all in the same
/// ratios, so that a filter's gains don't depend on the unit. 50 m/s^3 and 5 m/s^2 at 1 mm fit a
/// hand that reaches 0.3 m in 0.6 s.
MotionNoise motionNoise(double measured);

/// A predicted coordinate.
struct PredictedMotion
{
    double value = 0.0; ///< u
    double noise = 0.0; ///< u, > 0; standard deviation from the measurements' noise
    double lag = 0.0;   ///< u, >= 0; error if the assumed acceleration or jerk lasts

    double sigma() const { return std::sqrt(noise * noise + lag * lag); }
};

/// Tracks one coordinate of a motion, and predicts it. Measurements need not be equally spaced in
/// time. To be used by one thread. The caller must check that values are finite.
class MotionFilter
{
public:
    virtual ~MotionFilter() = default;

    /// Drops all data, and starts at \a value.
    virtual void restart(double value) = 0;

    /// Adds the measurement \a value, \a interval_s (> 0) after the last one.
    virtual void update(double interval_s, double value) = 0;

    /// Predicts the coordinate \a ahead_s (>= 0) after the last measurement.
    virtual PredictedMotion predict(double ahead_s) const = 0;
};

/// Makes the filter of \a method; null for OFF and TRACKER, which have none.
std::unique_ptr<MotionFilter> makeMotionFilter(PredictionMethod method, const MotionNoise& noise);

/// Gains of an alpha-beta filter.
struct AlphaBetaGains
{
    double alpha = 1.0;
    double beta = 1.0; ///< per interval: the correction of the speed is beta / interval
};

/// Returns the gains for measurements every \a interval_s (> 0): with Lambda = s_a T^2 / s_m and r
/// = (4 + Lambda - sqrt(8 Lambda + Lambda^2)) / 4, alpha = 1 - r^2 and beta = 2 (2 - alpha) - 4
/// sqrt(1 - alpha) (P. R. Kalata, "The tracking index", IEEE Trans. Aerospace and Electronic
/// Systems 20, 1984).
AlphaBetaGains kalataGains(double interval_s, const MotionNoise& noise);

/// Predicted motion since the last measurement.
struct PredictedShift
{
    Eigen::Vector3d shift = Eigen::Vector3d::Zero(); ///< u, added to the last measurement
    double sigma = 0.0; ///< u, > 0; expected error of the predicted place
};

/// Tracks three coordinates that belong together, and predicts them less and less as they come to
/// rest: a prediction amplifies noise, and overshoots a motion that has stopped.
class MotionTrack
{
public:
    /// Motions slower than this (m/s) aren't predicted, those faster than the second limit fully,
    /// and those in between by a share that rises with the pace: half at 0.05 m/s, which is 3.5 mm
    /// in 70 ms. Lower limits would pass the noise of a tracker that measures each joint
    /// separately.
    static constexpr double kRest = 0.035;
    static constexpr double kMoving = 0.07;
    /// The pace is measured between the means of the two halves of the last measurements: those of
    /// this time, at least kLeast.
    static constexpr double kWindow_s = 0.1;
    static constexpr std::size_t kLeast = 4;
    /// At this speed (m/s) MotionNoise's accelerations are assumed, at lower speeds proportionally
    /// less (as for reaches of equal duration), but at least a tenth.
    static constexpr double kReach = 0.5;
    static constexpr double kLeastReach = 0.1;
    /// Assumed speed (m/s) for sigma while the pace is unknown.
    static constexpr double kUnknown = 1.0;

    /// \a measured: noise of a coordinate, u (m or rad), > 0. \a metresPerUnit: motion of the skin
    /// per u; 1 for positions, the lever's length in m for rotations. \a method: one with a filter.
    MotionTrack(PredictionMethod method, double measured, double metresPerUnit);

    /// Drops all data except \a place, and starts with it at \a time_s.
    void restart(double time_s, const Eigen::Vector3d& place);

    /// Adds the measurement \a place at \a time_s, which has to be after the last one's.
    void update(double time_s, const Eigen::Vector3d& place);

    /// Predicts the motion from the last measurement to \a ahead_s (>= 0) after it.
    PredictedShift predict(double ahead_s) const;

    /// Returns the skin's speed, m/s. Only after kLeast measurements: isKnown().
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

    /// Returns the measurement \a back before the newest.
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
