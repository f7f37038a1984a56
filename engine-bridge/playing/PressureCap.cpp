#include "engine-bridge/playing/PressureCap.h"

#include "device/drive/DriveEncoder.h"
#include "device/limits/GuardedDevice.h"
#include "haptics/base/DutyLaw.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/sequence/FieldOrder.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

constexpr int kMostSteps = 24;
constexpr double kHeadroom = 0.999; // makes one step enough if the levels are fine
// Just above the amplitude of a level, which rounding down then gives.
constexpr double kAboveLevel = 1.0001;
// Error of haptics::pressureAt(), relative to the pressure of all transducers in phase.
constexpr float kFieldError = 1e-5f;

// sum_i P0 g_i a_i / R_il for each point: an upper bound on the pressure of transducers at
// amplitudes a, all in phase, since D <= 1 and the air absorbs some. R is at least
// kNearestDistance_m, as in the model itself.
Eigen::VectorXf inPhase(const Eigen::Matrix3Xd& points,
                        const haptics::TransducerArray& array,
                        const Eigen::VectorXf& amplitudes)
{
    const Eigen::Array3Xf from = array.positions.cast<float>().array();
    Eigen::ArrayXf strength = static_cast<float>(array.sourceAmplitude_Pa_m) * amplitudes.array();
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

// True if all transducers that are on have one amplitude: a lower gain then makes the same field,
// only quieter.
bool isEven(const device::DriveSignal& signal)
{
    std::uint8_t one = 0;
    for (const std::uint8_t duty : signal.duty)
    {
        if (duty == 0) continue;
        if (one != 0 && duty != one) return false;
        one = duty;
    }
    return true;
}

// The largest |f_0 p_0 + f_1 p_1 + ..| over all f in [0, 1], for each point, p (n x parts). It is
// convex in f, so largest where each is 0 or 1. For more than kMostParts parts the sum of the
// magnitudes, an upper bound.
Eigen::VectorXf mostOfParts(const Eigen::MatrixXcf& p)
{
    constexpr Eigen::Index kMostParts = 4;
    if (p.cols() > kMostParts) return p.cwiseAbs().rowwise().sum();
    Eigen::VectorXf most = Eigen::VectorXf::Zero(p.rows());
    for (unsigned subset = 1; subset < 1u << p.cols(); ++subset)
    {
        Eigen::VectorXcf sum = Eigen::VectorXcf::Zero(p.rows());
        for (Eigen::Index k = 0; k < p.cols(); ++k)
            if ((subset >> k & 1u) != 0) sum += p.col(k);
        most = most.cwiseMax(sum.cwiseAbs());
    }
    return most;
}

// The complex pressures (n x parts) of each part of the array by itself.
Eigen::MatrixXcf pressureOfParts(const PressureCap::Where& where,
                                 const haptics::TransducerArray& array,
                                 const Eigen::VectorXcf& q,
                                 const std::vector<int>& part)
{
    if (part.empty())
        return haptics::pressureAt(where.points, array, where.medium, q, where.threads, where.stop);
    const int parts = 1 + *std::max_element(part.begin(), part.end());
    Eigen::MatrixXcf p(where.points.cols(), parts);
    for (int k = 0; k < parts; ++k)
    {
        Eigen::VectorXcf own = q;
        for (Eigen::Index i = 0; i < own.size(); ++i)
            if (part[static_cast<std::size_t>(i)] != k) own[i] = 0.0f;
        p.col(k) =
            haptics::pressureAt(where.points, array, where.medium, own, where.threads, where.stop);
    }
    return p;
}

// The most that an amplitude changes when it is rounded down to a duty level and then by the device
// to one of its amplitudes.
float coarsestStep(const std::vector<float>& amplitudes)
{
    constexpr auto kDutyStep = static_cast<float>(base::kPi / base::kDutyPeriod); // sin's steepest
    float step = 0.0f;
    for (std::size_t i = 1; i < amplitudes.size(); ++i)
        step = std::max(step, amplitudes[i] - amplitudes[i - 1]);
    return amplitudes.empty() ? kDutyStep : kDutyStep + 2.0f * step;
}

double largest(const std::vector<Eigen::VectorXcf>& fields)
{
    float most = 0.0f;
    for (const Eigen::VectorXcf& q : fields)
        if (q.size() > 0) most = std::max(most, q.cwiseAbs().maxCoeff());
    return static_cast<double>(most);
}

double power(const std::vector<Eigen::VectorXcf>& fields)
{
    double sum = 0.0;
    for (const Eigen::VectorXcf& q : fields)
        sum += static_cast<double>(q.squaredNorm());
    return sum;
}

} // namespace

PressureCap::PressureCap(double max_Pa, Play play, device::DriveAbility ability) :
    _max_Pa(max_Pa),
    _play(std::move(play)),
    _ability(std::move(ability)),
    _coarsest(coarsestStep(_ability.amplitudes))
{
    if (!(max_Pa > 0.0 && max_Pa <= base::kMostPressure_Pa))
        throw base::InputError(
            fmt::format("cap of pressure is {:g} Pa, should be over 0 and at most 1e6", max_Pa));
}

// The largest pressure at any point for any of the arrays, plus the error of its computation.
double PressureCap::loudest(const Where& where,
                            const device::DriveSignal& signal,
                            CappedField& field) const
{
    const bool rounds = (_ability.fades || where.modulated) && !isEven(signal);
    const Eigen::VectorXf amplitudes = field.played.cwiseAbs();
    Eigen::VectorXf rounding;
    if (rounds) rounding = amplitudes.cwiseMin(_coarsest);
    double most_Pa = 0.0;
    for (const haptics::TransducerArray* array : where.arrays)
    {
        const Eigen::MatrixXcf p = pressureOfParts(where, *array, field.played, _ability.part);
        const Eigen::VectorXf inPhase_Pa = inPhase(where.points, *array, amplitudes);
        Eigen::VectorXf bound_Pa = mostOfParts(p) + kFieldError * inPhase_Pa;
        if (rounds)
            bound_Pa = (bound_Pa + inPhase(where.points, *array, rounding)).cwiseMin(inPhase_Pa);
        if (array == where.arrays.front()) field.achieved_Pa = p.rowwise().sum().cwiseAbs();
        // Not max(), which may ignore NaN.
        for (const float one : bound_Pa)
            if (!(one <= most_Pa)) most_Pa = one;
    }
    return most_Pa;
}

CappedField PressureCap::hold(const Where& where, device::DriveSignal& signal) const
{
    CappedField field;
    const device::DriveSignal wanted = signal;
    for (int step = 0; step < kMostSteps && field.factor > 0.0; ++step)
    {
        field.played = _play(signal);
        if (step > 0 && field.played.isZero(0.0f)) break;
        const double most_Pa = loudest(where, signal, field);
        if (most_Pa <= _max_Pa) return field;
        // With coarse levels a step may change nothing, so each next step is larger.
        field.factor *= kHeadroom * std::min(_max_Pa / most_Pa, std::pow(0.8, step));
        if (!std::isfinite(field.factor)) break;
        device::scaleDuties(wanted, field.factor, signal);
    }
    field.factor = 0.0;
    std::fill(signal.duty.begin(), signal.duty.end(), std::uint8_t(0));
    field.played.setZero(signal.size());
    field.achieved_Pa.setZero(where.points.cols());
    return field;
}

double PressureCap::holdAll(const Where& where, std::vector<Eigen::VectorXcf>& fields) const
{
    const std::vector<Eigen::VectorXcf> wanted = fields;
    bool sounds = false; // anything of the fields at the last step
    // The factor that brings the loudest field down to the cap, as far as one step can tell; 1: all
    // keep to it.
    const auto nextFactor = [&]
    {
        double least = 1.0;
        sounds = false;
        for (const Eigen::VectorXcf& q : fields)
        {
            device::DriveSignal signal;
            if (!device::encode(q.data(), static_cast<int>(q.size()), signal))
                throw base::InputError("field in turn has an activation that is not finite");
            CappedField field;
            field.played = _play(signal);
            sounds = sounds || !field.played.isZero(0.0f);
            const double most_Pa = loudest(where, signal, field);
            if (most_Pa <= _max_Pa) continue;
            const double factor = kHeadroom * _max_Pa / most_Pa;
            least = std::isfinite(factor) ? std::min(least, factor) : 0.0;
        }
        return least;
    };
    const auto scaleTo = [&](double whole)
    {
        fields = wanted;
        for (Eigen::VectorXcf& q : fields)
            haptics::scaleField(q, static_cast<float>(whole), where.arrays.front()->drive);
    };
    double whole = 1.0;
    for (int step = 0; step < kMostSteps && whole > 0.0; ++step)
    {
        const double factor = nextFactor();
        if (factor >= 1.0 && (step == 0 || sounds)) return whole;
        if (factor >= 1.0) break; // past the lowest level
        // With steps that grow, since rounding may raise the pressure again.
        whole *= factor * (1.0 - std::ldexp(1.0 - kHeadroom, std::min(step, 9)));
        scaleTo(whole);
    }
    // The steps may have passed the lowest level, which perhaps keeps to the cap.
    const double lowestShare = kAboveLevel * lowest(where, wanted).amplitude / largest(wanted);
    if (lowestShare > 0.0 && lowestShare < 1.0)
    {
        scaleTo(lowestShare);
        if (nextFactor() >= 1.0 && sounds) return lowestShare;
    }
    for (Eigen::VectorXcf& q : fields)
        q.setZero();
    return 0.0;
}

// Levels are rounded down, so the factor that was asked for is not the one that is played.
double PressureCap::hold(const Where& where, haptics::FieldSequence& sequence) const
{
    const double before = power(sequence.fields);
    const double factor = sequence.isHeld() ? holdHeld(where, sequence.fields.front())
                                            : holdAll(where, sequence.fields);
    if (factor >= 1.0 || factor <= 0.0 || before <= 0.0) return factor;
    return std::min(1.0, std::sqrt(power(sequence.fields) / before));
}

double PressureCap::holdHeld(const Where& where, Eigen::VectorXcf& q) const
{
    device::DriveSignal signal;
    if (!device::encode(q.data(), static_cast<int>(q.size()), signal))
        throw base::InputError("solver gave activations that are not finite; nothing is played");
    const double factor = hold(where, signal).factor;
    if (factor >= 1.0) return factor;
    std::vector<std::complex<float>> lowered;
    device::decode(signal, lowered);
    q = Eigen::Map<const Eigen::VectorXcf>(lowered.data(), q.size());
    return factor;
}

std::string PressureCap::message() const
{
    return fmt::format("the field is held down to the cap of {:g} Pa at any control point",
                       _max_Pa);
}

} // namespace midair::bridge
