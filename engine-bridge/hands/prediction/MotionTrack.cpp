#include "engine-bridge/hands/prediction/MotionTrack.h"

#include "haptics/base/Units.h"

#include <algorithm>

namespace midair::bridge
{

namespace
{

/// m/s and m/s^2 at a noise of 1 mm: assumed limits of speed and acceleration after one
/// measurement.
constexpr double kFirstSpeed = 1.0;
constexpr double kFirstAcceleration = 10.0;

/// Filters whose state, the coordinate and its first N - 1 derivatives, is corrected in proportion
/// to the innovation. The next derivative, the drive, is unknown. They also track the state's
/// errors: the covariance from the measurements' noise, and the error from a constant drive. These
/// are kept apart, unlike in a Kalman filter's P, because the jerk of a reach lasts for many
/// measurements and errs to one side.
template<int N>
class LinearFilter : public MotionFilter
{
public:
    using Vector = Eigen::Matrix<double, N, 1>;
    using Matrix = Eigen::Matrix<double, N, N>;

    LinearFilter(const MotionNoise& noise, double drive) : _noise(noise), _drive(drive) {}

    void restart(double value) override
    {
        _state.setZero();
        _state[0] = value;
        _covariance = firstCovariance();
        _lag.setZero();
        _measurements = 1;
    }

    void update(double interval_s, double value) override
    {
        ++_measurements;
        const Matrix step = transition(interval_s);
        const Vector gain = gains(interval_s);
        _state = step * _state;
        _state += gain * (value - _state[0]);
        Matrix kept = Matrix::Identity();
        kept.col(0) -= gain;
        const Matrix carried = kept * step;
        _covariance = carried * _covariance * carried.transpose() +
                      gain * gain.transpose() * (_noise.measured * _noise.measured);
        _lag = carried * _lag + kept * driven(interval_s) * _drive;
    }

    PredictedMotion predict(double ahead_s) const override
    {
        const Eigen::Matrix<double, 1, N> step = transition(ahead_s).row(0);
        const double variance = step * _covariance * step.transpose();
        const double lag = step * _lag + driven(ahead_s)[0] * _drive;
        return {step * _state, std::sqrt(std::max(variance, 0.0)), std::abs(lag)};
    }

protected:
    /// Returns the gains for a measurement \a interval_s after the last one.
    virtual Vector gains(double interval_s) = 0;

    /// Transition of the state without a drive: row i has T^(j - i) / (j - i)!.
    static Matrix transition(double interval_s)
    {
        Matrix step = Matrix::Zero();
        for (int i = 0; i < N; ++i)
        {
            double term = 1.0;
            for (int j = i; j < N; ++j)
            {
                step(i, j) = term;
                term *= interval_s / (j - i + 1);
            }
        }
        return step;
    }

    /// Effect of a drive of 1 on the state: [T^3 / 6, T^2 / 2, T] for N = 3.
    static Vector driven(double interval_s)
    {
        Vector added;
        double term = 1.0;
        for (int i = N - 1; i >= 0; --i)
        {
            term *= interval_s / (N - i);
            added[i] = term;
        }
        return added;
    }

    Matrix firstCovariance() const
    {
        const double perMetre = _noise.measured / MotionNoise().measured;
        const double known[] = {
            _noise.measured, kFirstSpeed * perMetre, kFirstAcceleration * perMetre};
        Matrix first = Matrix::Zero();
        for (int i = 0; i < N; ++i)
            first(i, i) = known[i] * known[i];
        return first;
    }

    const MotionNoise _noise;
    const double _drive;   ///< u/s^N
    int _measurements = 0; ///< since the restart

private:
    Vector _state = Vector::Zero();
    Matrix _covariance = Matrix::Zero();
    Vector _lag = Vector::Zero();
};

class AlphaBetaFilter : public LinearFilter<2>
{
public:
    explicit AlphaBetaFilter(const MotionNoise& noise) : LinearFilter<2>(noise, noise.acceleration)
    {
    }

private:
    // The first measurements use the gains of a straight line fitted to all of them, as long as
    // these are larger: the steady gains would take long to reach the speed.
    Vector gains(double interval_s) override
    {
        AlphaBetaGains used = kalataGains(interval_s, _noise);
        const double k = _measurements;
        const double beta = 6.0 / (k * (k + 1.0));
        if (beta > used.beta) used = {2.0 * (2.0 * k - 1.0) / (k * (k + 1.0)), beta};
        return {used.alpha, used.beta / interval_s};
    }
};

class KalmanFilter : public LinearFilter<3>
{
public:
    explicit KalmanFilter(const MotionNoise& noise) : LinearFilter<3>(noise, noise.jerk) {}

    void restart(double value) override
    {
        LinearFilter<3>::restart(value);
        _expected = firstCovariance();
    }

private:
    Vector gains(double interval_s) override
    {
        const Matrix step = transition(interval_s);
        const Vector drive = driven(interval_s) * _noise.jerk;
        _expected = step * _expected * step.transpose() + drive * drive.transpose();
        Vector gain = _expected.col(0) / (_expected(0, 0) + _noise.measured * _noise.measured);
        _expected -= (gain * _expected.row(0)).eval();
        _expected = (0.5 * (_expected + _expected.transpose())).eval();
        return gain;
    }

    Matrix _expected = Matrix::Zero(); ///< the P of textbooks, which determines the gains
};

/// The one euro filter (G. Casiez, N. Roussel, D. Vogel, "1 euro filter", CHI 2012): a low-pass
/// whose corner f_min + b |speed| rises with the speed, which has its own low-pass. It lags a
/// steady motion by tau = 1 / (2 pi f), which the prediction compensates.
class OneEuroFilter : public MotionFilter
{
public:
    explicit OneEuroFilter(const MotionNoise& noise) : _noise(noise) {}

    void restart(double value) override
    {
        _last = _smooth = value;
        _speed = 0.0;
        _lag_s = 1.0 / (base::kTwoPi * kLeast_Hz);
        _share = 1.0;
    }

    void update(double interval_s, double value) override
    {
        _interval_s = interval_s;
        _speed += share(kSpeedLag_s) * ((value - _last) / interval_s - _speed);
        const double perMetre = MotionNoise().measured / _noise.measured;
        const double corner_Hz = kLeast_Hz + kSlope_Hz * std::abs(_speed) * perMetre;
        _lag_s = 1.0 / (base::kTwoPi * corner_Hz);
        _share = share(_lag_s);
        _smooth += _share * (value - _smooth);
        _last = value;
    }

    // Sigma of a steady state. A low-pass of share a leaves a / (2 - a) of a variance, and for
    // differences 2 a^2 / (2 - a) over the square of the interval. An acceleration A causes an
    // error of A (h^2 / 2 - tau^2 + (tau_v + T / 2) (h + tau)).
    PredictedMotion predict(double ahead_s) const override
    {
        const double reach_s = ahead_s + _lag_s;
        const double speedShare = share(kSpeedLag_s);
        const double place = _noise.measured * std::sqrt(_share / (2.0 - _share));
        const double speed =
            _noise.measured / _interval_s * speedShare * std::sqrt(2.0 / (2.0 - speedShare));
        const double lag =
            0.5 * ahead_s * ahead_s - _lag_s * _lag_s + (kSpeedLag_s + 0.5 * _interval_s) * reach_s;
        return {_smooth + _speed * reach_s,
                place + speed * reach_s,
                std::abs(lag) * _noise.acceleration};
    }

private:
    // Chosen with the reaches of midair-hands-bench, which prints their results.
    static constexpr double kLeast_Hz = 6.0;
    static constexpr double kSlope_Hz = 30.0; ///< at 1 m/s
    static constexpr double kSpeedLag_s = 0.02;

    /// Share of the new value in a low-pass with the lag \a lag_s.
    double share(double lag_s) const { return _interval_s / (_interval_s + lag_s); }

    const MotionNoise _noise;
    double _interval_s = 1.0 / 90.0;
    double _last = 0.0;
    double _smooth = 0.0;
    double _speed = 0.0; ///< u/s
    double _lag_s = 0.0;
    double _share = 1.0;
};

} // namespace

MotionNoise motionNoise(double measured)
{
    const MotionNoise normal;
    const double scale = measured / normal.measured;
    return {measured, normal.acceleration * scale, normal.jerk * scale};
}

AlphaBetaGains kalataGains(double interval_s, const MotionNoise& noise)
{
    const double index = noise.acceleration * interval_s * interval_s / noise.measured;
    const double r = (4.0 + index - std::sqrt(8.0 * index + index * index)) / 4.0;
    const double alpha = 1.0 - r * r;
    return {alpha, 2.0 * (2.0 - alpha) - 4.0 * std::sqrt(1.0 - alpha)};
}

std::unique_ptr<MotionFilter> makeMotionFilter(PredictionMethod method, const MotionNoise& noise)
{
    switch (method)
    {
    case PredictionMethod::ALPHA_BETA:
        return std::make_unique<AlphaBetaFilter>(noise);
    case PredictionMethod::KALMAN:
        return std::make_unique<KalmanFilter>(noise);
    case PredictionMethod::ONE_EURO:
        return std::make_unique<OneEuroFilter>(noise);
    case PredictionMethod::OFF:
    case PredictionMethod::TRACKER:
        break;
    }
    return nullptr;
}

MotionTrack::MotionTrack(PredictionMethod method, double measured, double metresPerUnit) :
    _measured(measured),
    _metresPerUnit(metresPerUnit)
{
    for (std::unique_ptr<MotionFilter>& filter : _filters)
        filter = makeMotionFilter(method, motionNoise(measured));
}

void MotionTrack::restart(double time_s, const Eigen::Vector3d& place)
{
    _newest = 0;
    _count = 1;
    _recent[0] = {time_s, place};
    for (Eigen::Index axis = 0; axis < 3; ++axis)
        _filters[static_cast<std::size_t>(axis)]->restart(place[axis]);
}

void MotionTrack::update(double time_s, const Eigen::Vector3d& place)
{
    const double interval_s = time_s - _recent[_newest].time_s;
    _newest = (_newest + 1) % kMost;
    _count = std::min(_count + 1, kMost);
    _recent[_newest] = {time_s, place};
    for (Eigen::Index axis = 0; axis < 3; ++axis)
        _filters[static_cast<std::size_t>(axis)]->update(interval_s, place[axis]);
}

double MotionTrack::pace() const
{
    std::size_t within = kLeast;
    while (within < _count && time_s() - before(within).time_s <= kWindow_s)
        ++within;
    const std::size_t half = within / 2;
    Eigen::Vector3d way = Eigen::Vector3d::Zero();
    double time = 0.0;
    for (std::size_t i = 0; i < half; ++i)
    {
        way += before(i).place - before(within - 1 - i).place;
        time += before(i).time_s - before(within - 1 - i).time_s;
    }
    return way.norm() / time * _metresPerUnit;
}

PredictedShift MotionTrack::predict(double ahead_s) const
{
    if (!isKnown())
        return {Eigen::Vector3d::Zero(),
                std::hypot(_measured, kUnknown / _metresPerUnit * ahead_s)};
    const double speed = pace();
    const double share = std::clamp((speed - kRest) / (kMoving - kRest), 0.0, 1.0);
    const double still = std::hypot(_measured, speed / _metresPerUnit * ahead_s);
    if (share == 0.0) return {Eigen::Vector3d::Zero(), still};
    const double reach = std::clamp(speed / kReach, kLeastReach, 1.0);
    PredictedShift result;
    double sigma = 0.0;
    for (Eigen::Index axis = 0; axis < 3; ++axis)
    {
        const PredictedMotion motion = _filters[static_cast<std::size_t>(axis)]->predict(ahead_s);
        result.shift[axis] = share * (motion.value - place()[axis]);
        sigma = std::max(sigma, std::hypot(motion.noise, reach * motion.lag));
    }
    result.sigma = share * sigma + (1.0 - share) * still;
    return result;
}

} // namespace midair::bridge
