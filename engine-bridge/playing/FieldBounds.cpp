#include "engine-bridge/playing/FieldBounds.h"

#include "haptics/propagation/PressureField.h"
#include "haptics/solvers/HologramSolver.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace midair::bridge
{

namespace
{

// Error of haptics::pressureAt(), relative to the pressure of all transducers in phase.
constexpr float kFieldError = 1e-5f;

constexpr Eigen::Index kPointsAtOnce = 8; // their columns stay in the cache

// P0 g_i / R_il for the points l from begin on (m x count): upper bounds on the pressures of single
// transducers at full drive, because D <= 1 and the air absorbs. R is at least kNearestDistance_m,
// as in the model.
Eigen::MatrixXf strongest(const Eigen::Matrix3Xd& points,
                          const haptics::TransducerArray& array,
                          Eigen::Index begin,
                          Eigen::Index count)
{
    const Eigen::Matrix3Xf from = array.positions.cast<float>();
    Eigen::ArrayXf strength =
        Eigen::ArrayXf::Constant(array.size(), static_cast<float>(array.sourceAmplitude_Pa_m));
    if (array.gain.size() > 0) strength *= array.gain.cast<float>().array().abs();
    constexpr auto kNearest2 =
        static_cast<float>(haptics::kNearestDistance_m * haptics::kNearestDistance_m);
    Eigen::MatrixXf each(array.size(), count);
    for (Eigen::Index l = 0; l < count; ++l)
    {
        const Eigen::Vector3f r = points.col(begin + l).cast<float>();
        each.col(l) =
            strength *
            (from.colwise() - r).colwise().squaredNorm().transpose().array().max(kNearest2).rsqrt();
    }
    return each;
}

// The pressures (n x K) of all transducers in phase, at each column of amplitudes (m x K).
Eigen::MatrixXf inPhase(const Eigen::Matrix3Xd& points,
                        const haptics::TransducerArray& array,
                        const Eigen::MatrixXf& amplitudes)
{
    Eigen::MatrixXf sum(points.cols(), amplitudes.cols());
    for (Eigen::Index begin = 0; begin < points.cols(); begin += kPointsAtOnce)
    {
        const Eigen::Index count = std::min(kPointsAtOnce, points.cols() - begin);
        sum.middleRows(begin, count).noalias() =
            strongest(points, array, begin, count).transpose() * amplitudes;
    }
    return sum;
}

// 2-norms of strongest() for each point: times the 2-norm of the amplitudes they bound inPhase()
// from above (Cauchy and Schwarz).
Eigen::VectorXf norms(const Eigen::Matrix3Xd& points, const haptics::TransducerArray& array)
{
    constexpr auto kNearest2 =
        static_cast<float>(haptics::kNearestDistance_m * haptics::kNearestDistance_m);
    const Eigen::ArrayX3f from = array.positions.cast<float>().transpose();
    Eigen::ArrayXf gain2 = Eigen::ArrayXf::Ones(array.size());
    if (array.gain.size() > 0) gain2 = array.gain.cast<float>().array().square();
    Eigen::VectorXf all(points.cols());
    for (Eigen::Index l = 0; l < points.cols(); ++l)
    {
        const Eigen::Vector3f r = points.col(l).cast<float>();
        const float squares =
            (gain2 / ((from.col(0) - r[0]).square() + (from.col(1) - r[1]).square() +
                      (from.col(2) - r[2]).square())
                         .max(kNearest2))
                .sum();
        all[l] = static_cast<float>(array.sourceAmplitude_Pa_m) * std::sqrt(squares);
    }
    return all;
}

// Upper bounds on norms() without a loop over the transducers: R is at least the distance of the
// point from the shell that contains all transducers, seen from the array's middle.
Eigen::VectorXf looseNorms(const Eigen::Matrix3Xd& points, const haptics::TransducerArray& array)
{
    constexpr double kRounding = 1.001; // of floats, generously
    const Eigen::Vector3d middle =
        0.5 * (array.positions.rowwise().minCoeff() + array.positions.rowwise().maxCoeff());
    const Eigen::VectorXd from = (array.positions.colwise() - middle).colwise().norm();
    const double strength = array.sourceAmplitude_Pa_m *
                            std::sqrt(static_cast<double>(array.size())) *
                            (array.gain.size() > 0 ? array.gain.cwiseAbs().maxCoeff() : 1.0);
    const Eigen::ArrayXd away = (points.colwise() - middle).colwise().norm().transpose();
    const Eigen::ArrayXd nearest =
        (from.minCoeff() - away).max(away - from.maxCoeff()).max(haptics::kNearestDistance_m);
    return (kRounding * strength / nearest).cast<float>();
}

// Bounds in Pa (n x K) for fields whose amplitudes may be rounded again, given the bounds most_Pa
// (n x K) of the fields themselves.
void addRounding(const CappedPlaces& where,
                 const haptics::TransducerArray& array,
                 const std::vector<Eigen::VectorXcf>& fields,
                 const std::vector<float>& rounding,
                 Eigen::MatrixXf& most_Pa)
{
    std::vector<std::size_t> rounded;
    for (std::size_t k = 0; k < fields.size(); ++k)
        if (rounding[k] > 0.0f) rounded.push_back(k);
    if (rounded.empty()) return;
    const auto count = static_cast<Eigen::Index>(rounded.size());
    // Amplitudes, then their changes by rounding.
    Eigen::MatrixXf amplitudes(array.size(), 2 * count);
    for (Eigen::Index j = 0; j < count; ++j)
    {
        const std::size_t k = rounded[static_cast<std::size_t>(j)];
        amplitudes.col(j) = fields[k].cwiseAbs();
        amplitudes.col(count + j) = amplitudes.col(j).cwiseMin(rounding[k]);
    }
    const Eigen::MatrixXf inPhase_Pa = inPhase(where.points, array, amplitudes);
    for (Eigen::Index j = 0; j < count; ++j)
    {
        auto one_Pa = most_Pa.col(static_cast<Eigen::Index>(rounded[static_cast<std::size_t>(j)]));
        one_Pa = (one_Pa + inPhase_Pa.col(count + j)).cwiseMin(inPhase_Pa.col(j)).eval();
    }
}

} // namespace

// The magnitude is convex in f, so it is largest where each f is 0 or 1. For more than kMostParts
// parts: the sum of magnitudes, an upper bound.
Eigen::VectorXf mostOfParts(const Eigen::Ref<const Eigen::MatrixXcf>& p)
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

FieldBounds::FieldBounds(const CappedPlaces& where,
                         const device::DriveAbility& ability,
                         CappedField known) :
    _where(where),
    _ability(ability),
    _known(std::move(known))
{
    if (!ability.part.empty())
        _parts = 1 + *std::max_element(ability.part.begin(), ability.part.end());
    _norm_Pa.resize(where.arrays.size());
    _looseNorm_Pa.resize(where.arrays.size());
}

const Eigen::VectorXf& FieldBounds::looseNormOf(std::size_t array) const
{
    Eigen::VectorXf& known = _looseNorm_Pa[array];
    if (known.size() == 0) known = looseNorms(_where.points, *_where.arrays[array]);
    return known;
}

const Eigen::VectorXf& FieldBounds::normOf(std::size_t array) const
{
    Eigen::VectorXf& known = _norm_Pa[array];
    if (known.size() == 0) known = norms(_where.points, *_where.arrays[array]);
    return known;
}

// The complex pressures of each part of the array by itself: n x (K parts), field by field.
Eigen::MatrixXcf FieldBounds::pressureOfParts(const haptics::TransducerArray& array,
                                              const std::vector<Eigen::VectorXcf>& fields) const
{
    const auto pressures = [&](const std::vector<Eigen::VectorXcf>& all)
    {
        return haptics::pressuresAt(
            _where.points, array, _where.medium, all, _where.threads, _where.stop);
    };
    if (_parts == 1) return pressures(fields);
    std::vector<Eigen::VectorXcf> alone;
    for (const Eigen::VectorXcf& q : fields)
        for (int part = 0; part < static_cast<int>(_parts); ++part)
        {
            alone.push_back(q);
            for (Eigen::Index i = 0; i < q.size(); ++i)
                if (_ability.part[static_cast<std::size_t>(i)] != part) alone.back()[i] = 0.0f;
        }
    return pressures(alone);
}

// For the pressures \a p of the parts (n x (K parts)).
Eigen::MatrixXf FieldBounds::boundsOf(const haptics::TransducerArray& array,
                                      const Eigen::VectorXf& norm_Pa,
                                      const Eigen::MatrixXcf& p,
                                      const std::vector<Eigen::VectorXcf>& fields,
                                      const std::vector<float>& rounding) const
{
    const auto K = static_cast<Eigen::Index>(fields.size());
    Eigen::MatrixXf bound_Pa(_where.points.cols(), K);
    for (Eigen::Index k = 0; k < K; ++k)
    {
        const Eigen::VectorXcf& q = fields[static_cast<std::size_t>(k)];
        bound_Pa.col(k) =
            mostOfParts(p.middleCols(k * _parts, _parts)) + kFieldError * q.norm() * norm_Pa;
    }
    addRounding(_where, array, fields, rounding, bound_Pa);
    return bound_Pa;
}

// If the only field is proportional to the known one, so are its pressures. Returns false if it
// isn't, or if the known pressures are too inexact to decide whether \a enough_Pa is kept.
bool FieldBounds::boundByKnown(const std::vector<Eigen::VectorXcf>& fields,
                               const std::vector<float>& rounding,
                               double enough_Pa,
                               Eigen::MatrixXf& achieved_Pa,
                               double& most_Pa) const
{
    constexpr float kSame = 1e-5f; // sums in single precision, and the device's tables of levels
    if (fields.size() != 1 || _parts != 1 || _where.arrays.size() != 1 || rounding[0] > 0.0f ||
        !(enough_Pa > 0.0) || _known.achieved_Pa.size() != _where.points.cols() ||
        _known.achieved_Pa.size() == 0 || _known.played.size() != fields[0].size())
        return false;
    const Eigen::VectorXcf& q = fields[0];
    const float power = _known.played.squaredNorm();
    const float share = power > 0.0f ? _known.played.dot(q).real() / power : 0.0f;
    const float norm = q.norm();
    if (!(share > 0.0f) || !((q - share * _known.played).norm() <= kSame * norm)) return false;
    constexpr float kError = kFieldError + haptics::HologramSolver::kAchievedError + kSame;
    const Eigen::VectorXf error_Pa = kError * norm * looseNormOf(0);
    const Eigen::VectorXf found_Pa = share * _known.achieved_Pa;
    if (!found_Pa.allFinite() || !error_Pa.allFinite()) return false;
    const float bound_Pa = (found_Pa + error_Pa).maxCoeff();
    const auto enough = static_cast<float>(enough_Pa);
    const bool isOver = (found_Pa - error_Pa).maxCoeff() > enough;
    if (bound_Pa > enough && !isOver) return false;
    achieved_Pa = found_Pa;
    // Over the limit no margin is needed: the replacement is checked again.
    most_Pa = static_cast<double>(isOver ? found_Pa.maxCoeff() : bound_Pa);
    return true;
}

std::vector<double> FieldBounds::of(const std::vector<Eigen::VectorXcf>& fields,
                                    const std::vector<float>& rounding,
                                    Eigen::MatrixXf& achieved_Pa,
                                    double enough_Pa) const
{
    const auto K = static_cast<Eigen::Index>(fields.size());
    achieved_Pa.setZero(_where.points.cols(), K);
    std::vector<double> most_Pa(fields.size(), 0.0);
    if (boundByKnown(fields, rounding, enough_Pa, achieved_Pa, most_Pa.front())) return most_Pa;
    for (std::size_t a = 0; a < _where.arrays.size(); ++a)
    {
        const haptics::TransducerArray& array = *_where.arrays[a];
        const Eigen::MatrixXcf p = pressureOfParts(array, fields);
        for (Eigen::Index k = 0; k < K && a == 0; ++k)
            achieved_Pa.col(k) = p.middleCols(k * _parts, _parts).rowwise().sum().cwiseAbs();
        Eigen::MatrixXf bound_Pa = boundsOf(array, looseNormOf(a), p, fields, rounding);
        // Written so that NaN isn't enough.
        if (!(bound_Pa.array() <= static_cast<float>(enough_Pa)).all())
            bound_Pa = boundsOf(array, normOf(a), p, fields, rounding);
        // Not max(), which may ignore NaN.
        for (Eigen::Index k = 0; k < K; ++k)
            for (const float one_Pa : bound_Pa.col(k))
                if (double& most = most_Pa[static_cast<std::size_t>(k)]; !(one_Pa <= most))
                    most = static_cast<double>(one_Pa);
    }
    return most_Pa;
}

} // namespace midair::bridge
