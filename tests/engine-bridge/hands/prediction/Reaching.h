// Hands that reach to and fro, and what predictions of them err by: for tests and
// midair-hands-bench.
#pragma once

#include "engine-bridge/hands/Hand.h"
#include "engine-bridge/hands/prediction/MotionTrack.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

namespace midair::bridge
{

/// A place that goes 0.3 m to and fro in 0.6 s each way, with pauses of 0.3 to 0.4 s. Each way has
/// the least jerk (T. Flash, N. Hogan, J. Neuroscience 5, 1985): with s = t / 0.6 s,
/// x = 0.3 m (10 s^3 - 15 s^4 + 6 s^5).
class Reaching
{
public:
    static constexpr double kWay_m = 0.3;
    static constexpr double kTime_s = 0.6;

    explicit Reaching(double end_s, unsigned int seed = 1)
    {
        std::mt19937_64 random(seed);
        std::uniform_real_distribution<double> pause(0.3, 0.4);
        for (double start_s = 0.5; start_s < end_s; start_s += kTime_s + pause(random))
            _starts_s.push_back(start_s);
    }

    /// The place (m) at \a time_s.
    double at(double time_s) const
    {
        const auto next = std::upper_bound(_starts_s.begin(), _starts_s.end(), time_s);
        if (next == _starts_s.begin()) return 0.0;
        const double s = std::min(1.0, (time_s - *(next - 1)) / kTime_s);
        const double way = kWay_m * s * s * s * (10.0 - s * (15.0 - 6.0 * s));
        return (next - _starts_s.begin()) % 2 == 1 ? way : kWay_m - way;
    }

private:
    std::vector<double> _starts_s;
};

/// What predictions err by.
struct PredictionErrors
{
    double rms_m = 0.0;
    double most_m = 0.0;  ///< 95 % are at most this
    double sigma_m = 0.0; ///< expected, rms
};

inline PredictionErrors summed(std::vector<double> errors_m, const std::vector<double>& sigmas_m)
{
    PredictionErrors result;
    for (const double error : errors_m)
        result.rms_m += error * error / static_cast<double>(errors_m.size());
    for (const double sigma : sigmas_m)
        result.sigma_m += sigma * sigma / static_cast<double>(sigmas_m.size());
    result.rms_m = std::sqrt(result.rms_m);
    result.sigma_m = std::sqrt(result.sigma_m);
    for (double& error : errors_m)
        error = std::abs(error);
    std::sort(errors_m.begin(), errors_m.end());
    result.most_m = errors_m[errors_m.size() * 95 / 100];
    return result;
}

constexpr double kTracker_Hz = 90.0;
constexpr double kTrackerNoise_m = 1e-3;

/// The errors of a filter alone for one coordinate that reaches for two minutes, \a ahead_s ahead;
/// OFF: of the measurement as it is. \a moves: false: it is at rest.
inline PredictionErrors filterErrors(PredictionMethod method, double ahead_s, bool moves)
{
    const Reaching reaching(120.0);
    std::mt19937_64 random(2);
    std::normal_distribution<double> noise(0.0, kTrackerNoise_m);
    const auto filter = makeMotionFilter(method, MotionNoise());
    const auto truth = [&](double time_s) { return moves ? reaching.at(time_s) : 0.0; };
    if (filter) filter->restart(0.0);
    std::vector<double> errors;
    std::vector<double> sigmas;
    for (int i = 1; i < 119 * static_cast<int>(kTracker_Hz); ++i)
    {
        const double time_s = i / kTracker_Hz;
        PredictedMotion predicted{truth(time_s) + noise(random), kTrackerNoise_m, 0.0};
        if (filter)
        {
            filter->update(1.0 / kTracker_Hz, predicted.value);
            predicted = filter->predict(ahead_s);
        }
        if (time_s < 1.0) continue;
        errors.push_back(predicted.value - truth(time_s + ahead_s));
        sigmas.push_back(predicted.sigma());
    }
    return summed(std::move(errors), sigmas);
}

/// The same of a track, which rests when what it follows does; x moves, y and z don't, and x
/// counts.
inline PredictionErrors trackErrors(PredictionMethod method, double ahead_s, bool moves)
{
    const Reaching reaching(120.0);
    std::mt19937_64 random(2);
    std::normal_distribution<double> noise(0.0, kTrackerNoise_m);
    const auto truth = [&](double time_s) { return moves ? reaching.at(time_s) : 0.0; };
    MotionTrack track(method, kTrackerNoise_m, 1.0);
    track.restart(0.0, Eigen::Vector3d::Zero());
    std::vector<double> errors;
    std::vector<double> sigmas;
    for (int i = 1; i < 119 * static_cast<int>(kTracker_Hz); ++i)
    {
        const double time_s = i / kTracker_Hz;
        const double x = truth(time_s) + noise(random);
        track.update(time_s, {x, noise(random), noise(random)});
        const PredictedShift predicted = track.predict(ahead_s);
        if (time_s < 1.0) continue;
        errors.push_back(x + predicted.shift.x() - truth(time_s + ahead_s));
        sigmas.push_back(predicted.sigma);
    }
    return summed(std::move(errors), sigmas);
}

/// Bends the index finger of \a hand by \a angle (rad) at each of its three joints, towards the
/// palm: openHand()'s fingers point along -z of the palm, its back along y.
inline void bendIndex(const Eigen::Quaterniond& palm, double angle, Hand& hand)
{
    const Eigen::AngleAxisd bend(-angle, palm * Eigen::Vector3d::UnitX());
    for (int pivot = INDEX_PROXIMAL; pivot < INDEX_TIP; ++pivot)
    {
        const Eigen::Vector3d centre = hand.joints[static_cast<std::size_t>(pivot)].position;
        for (int joint = pivot + 1; joint <= INDEX_TIP; ++joint)
        {
            Eigen::Vector3d& place = hand.joints[static_cast<std::size_t>(joint)].position;
            place = centre + bend * (place - centre);
        }
    }
}

/// A right hand at \a time_s that reaches along x while it turns about y and bends its index
/// finger, both in proportion to the way: by 60 and by 40 degrees.
inline Hand reachingHand(const Reaching& reaching, double time_s)
{
    const double way = reaching.at(time_s) / Reaching::kWay_m;
    Eigen::Isometry3d palm = Eigen::Isometry3d::Identity();
    palm.linear() = Eigen::AngleAxisd(way * M_PI / 3.0, Eigen::Vector3d::UnitY()).matrix();
    palm.translation() = Eigen::Vector3d(reaching.at(time_s), 0.0, 0.0);
    Hand hand = openHand(1, palm);
    bendIndex(Eigen::Quaterniond(palm.linear()), way * M_PI * 2.0 / 9.0, hand);
    return hand;
}

/// Adds a tracker's noise to each joint of \a hand.
template<typename Random>
void addNoise(Random& random, double noise_m, Hand& hand)
{
    std::normal_distribution<double> noise(0.0, noise_m);
    for (HandJoint& joint : hand.joints)
        for (int axis = 0; axis < 3; ++axis)
            joint.position[axis] += noise(random);
}

} // namespace midair::bridge
