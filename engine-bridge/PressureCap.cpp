#include "engine-bridge/PressureCap.h"

#include "device/GuardedDevice.h"
#include "haptics/InputError.h"
#include "haptics/PressureField.h"

#include <algorithm>
#include <cmath>

namespace midair::bridge
{

namespace
{

constexpr double kMost_Pa = 1e6;
constexpr int kMostSteps = 24;
constexpr double kHeadroom = 0.999; // so that one step is enough where the levels are fine
constexpr float kFieldError =
    1e-5f; // haptics::pressureAt's, of what all transducers in phase would give

// sum_i P0 g_i |q_i| / R_il for each point: at least what all transducers in phase give there, since D <= 1 and the air takes
// some. R isn't taken below kNearestDistance_m, as in the model itself.
Eigen::VectorXf inPhase(const Eigen::Matrix3Xd& points,
                        const haptics::TransducerArray& array,
                        const Eigen::VectorXcf& q)
{
    const Eigen::Array3Xf from = array.positions.cast<float>().array();
    Eigen::ArrayXf strength = static_cast<float>(array.sourceAmplitude_Pa_m) * q.cwiseAbs().array();
    if (array.gain.size() > 0) strength *= array.gain.cast<float>().array().abs();
    const Eigen::ArrayXf x = from.row(0).transpose();
    const Eigen::ArrayXf y = from.row(1).transpose();
    const Eigen::ArrayXf z = from.row(2).transpose();
    constexpr auto kNearest2 =
        static_cast<float>(haptics::kNearestDistance_m * haptics::kNearestDistance_m);
    Eigen::VectorXf sum(points.cols());
    for (Eigen::Index l = 0; l < points.cols(); ++l)
    {
        const Eigen::Vector3f r = points.col(l).cast<float>();
        sum[l] = (strength * ((x - r.x()).square() + (y - r.y()).square() + (z - r.z()).square())
                                 .max(kNearest2)
                                 .rsqrt())
                     .sum();
    }
    return sum;
}

// The largest pressure anywhere in any of the arrays, with what its computation may be wrong by.
double loudest(const Eigen::Matrix3Xd& points,
               const std::vector<const haptics::TransducerArray*>& arrays,
               const haptics::Medium& medium,
               int threads,
               CappedField& field)
{
    double most_Pa = 0.0;
    for (const haptics::TransducerArray* array : arrays)
    {
        const Eigen::VectorXf p =
            haptics::pressureAt(points, *array, medium, field.played, threads).cwiseAbs();
        const Eigen::VectorXf bound = p + kFieldError * inPhase(points, *array, field.played);
        if (array == arrays.front()) field.achieved_Pa = p;
        // Not max(), which may pass over what is not a number.
        for (const float one : bound)
            if (!(one <= most_Pa)) most_Pa = one;
    }
    return most_Pa;
}

} // namespace

PressureCap::PressureCap(double max_Pa) : _max_Pa(max_Pa)
{
    if (!(max_Pa > 0.0 && max_Pa <= kMost_Pa))
        throw haptics::InputError("cap of pressure is " + std::to_string(max_Pa) +
                                  " Pa, should be over 0 and at most 1e6");
}

CappedField
PressureCap::hold(const Eigen::Matrix3Xd& points,
                  const std::vector<const haptics::TransducerArray*>& arrays,
                  const haptics::Medium& medium,
                  const std::function<Eigen::VectorXcf(const device::DriveSignal&)>& play,
                  device::DriveSignal& signal,
                  int threads) const
{
    CappedField field;
    const device::DriveSignal wanted = signal;
    for (int step = 0; step < kMostSteps && field.factor > 0.0; ++step)
    {
        field.played = play(signal);
        if (step > 0 && field.played.isZero(0.0f)) break;
        const double most_Pa = loudest(points, arrays, medium, threads, field);
        if (most_Pa <= _max_Pa) return field;
        // Where the levels are coarse a step may change nothing: each next one is larger.
        field.factor *= kHeadroom * std::min(_max_Pa / most_Pa, std::pow(0.8, step));
        if (!std::isfinite(field.factor)) break;
        device::scaleDuties(wanted, field.factor, signal);
    }
    field.factor = 0.0;
    std::fill(signal.duty.begin(), signal.duty.end(), std::uint8_t(0));
    field.played.setZero(signal.size());
    field.achieved_Pa.setZero(points.cols());
    return field;
}

// With the solvers' own definitions: s = (y.a)/(a.a), errors y/(s a) - 1, with absolute targets s = 1.
void rate(const haptics::ControlPoints& points,
          const Eigen::VectorXf& achieved_Pa,
          bool absolute,
          haptics::SolveReport& report)
{
    const Eigen::ArrayXd y = achieved_Pa.cast<double>().array();
    const Eigen::ArrayXd a = points.targets.array();
    const double s = (y * a).sum() / a.square().sum();
    const double level_Pa = s * a.maxCoeff();
    if (report.level_Pa > 0.0) report.loudness *= level_Pa / report.level_Pa;
    report.level_Pa = level_Pa;
    if (!(s > 0.0)) return; // silent: no error relative to nothing
    const Eigen::ArrayXd error = y / (a * (absolute ? 1.0 : s)) - 1.0;
    report.rms = std::sqrt(error.square().mean());
    report.max = error.abs().maxCoeff();
    if (!absolute) return;
    constexpr double kShort = 0.01;
    report.shortPoints = static_cast<int>((error < -kShort).count());
    report.worstShortfall = std::max(0.0, -error.minCoeff());
}

} // namespace midair::bridge
