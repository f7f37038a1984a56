#include "haptics/solvers/certificate/PhaseRelaxation.h"

#include "haptics/base/Units.h"
#include "haptics/solvers/LargeMatrix.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>
#include <vector>

namespace midair::haptics
{

namespace
{

constexpr int kFirstRounds = 4;         // rounds that show which roundings are promising
constexpr int kMaxRounds = 2000;        // largest number of rounds in a descent
constexpr double kSettled = 1e-8;       // fall of a round over trace(M) at which a descent ends
constexpr double kSettledFast = 1e-6;   // the same of a descent in float
constexpr float kSmallestStep = 1e-5f;  // shorter changes of a unit vector are skipped
constexpr float kRelaxationOver = 0.7f; // see kernels::descendOnce; measured, n = 50 to 200
constexpr int kRefreshInterval = 64;    // rounds between recomputations of the products M x

double normal(std::mt19937_64& random)
{
    // The method of Box and Muller, as the standard library's normal distribution differs between
    // implementations.
    const double scale = 1.0 / 18446744073709551616.0; // 2^-64
    const double radius = std::sqrt(-2.0 * std::log((static_cast<double>(random()) + 1.0) * scale));
    return radius * std::cos(base::kTwoPi * static_cast<double>(random()) * scale);
}

} // namespace

Eigen::VectorXcd unitPhases(const Eigen::VectorXcd& p)
{
    Eigen::VectorXcd u(p.size());
    for (Eigen::Index l = 0; l < p.size(); ++l)
    {
        const double modulus = std::abs(p[l]);
        u[l] = modulus > 0.0 ? p[l] / modulus : 1.0;
    }
    return u;
}

PhaseRelaxation::PhaseRelaxation(const PhaseObjective& objective,
                                 std::uint64_t seed,
                                 base::StopToken stop) :
    _objective(objective),
    _stop(std::move(stop))
{
    const int components = static_cast<int>(std::ceil(std::sqrt(objective.size()))) + 1;
    std::mt19937_64 random(seed);
    Eigen::MatrixXcd X(objective.size(), components);
    for (Eigen::Index l = 0; l < X.rows(); ++l)
        for (Eigen::Index c = 0; c < X.cols(); ++c)
        {
            const double re = normal(random);
            X(l, c) = {re, normal(random)};
        }
    assign(X);
}

void PhaseRelaxation::assign(const Eigen::MatrixXcd& X)
{
    const kernels::HermitianView<float> M = _objective.fastView();
    _xRe = Eigen::MatrixXf::Zero(M.stride, X.cols());
    _xIm = _sRe = _sIm = _xRe;
    for (Eigen::Index l = 0; l < X.rows(); ++l)
    {
        const double length = X.row(l).norm();
        if (length > 0.0)
        {
            _xRe.row(l) = (X.row(l).real() / length).cast<float>();
            _xIm.row(l) = (X.row(l).imag() / length).cast<float>();
        }
        else
            _xRe(l, 0) = 1.0f;
    }
    refreshProducts();
}

void PhaseRelaxation::refreshProducts()
{
    const kernels::HermitianView<float> M = _objective.fastView();
    for (Eigen::Index c = 0; c < _xRe.cols(); ++c)
    {
        _stop.throwIfRequested();
        kernels::multiplyMatrix(
            M, _xRe.col(c).data(), _xIm.col(c).data(), _sRe.col(c).data(), _sIm.col(c).data());
    }
}

void PhaseRelaxation::descend(int maxRounds, double fall)
{
    const kernels::HermitianView<float> M = _objective.fastView();
    while (_rounds < maxRounds)
    {
        _stop.throwIfRequested();
        const double fell = kernels::descendOnce(M,
                                                 rank(),
                                                 kRelaxationOver,
                                                 kSmallestStep,
                                                 _xRe.data(),
                                                 _xIm.data(),
                                                 _sRe.data(),
                                                 _sIm.data());
        ++_rounds;
        if (_rounds % kRefreshInterval == 0) refreshProducts();
        if (!(fell > fall * _objective.size())) break;
    }
    refreshProducts();
}

Eigen::MatrixXcd PhaseRelaxation::vectors() const
{
    Eigen::MatrixXcd X(_objective.size(), rank());
    X.real() = _xRe.topRows(X.rows()).cast<double>();
    X.imag() = _xIm.topRows(X.rows()).cast<double>();
    X.rowwise().normalize();
    return X;
}

Eigen::VectorXd PhaseRelaxation::y() const
{
    const Eigen::MatrixXcd X = vectors();
    return X.conjugate().cwiseProduct(_objective.M() * X).real().rowwise().sum();
}

void PhaseRelaxation::reduceRank()
{
    const Eigen::MatrixXcd X = vectors();
    const HermitianAxes gram = hermitianAxes(X.adjoint() * X);
    const Eigen::Index all = X.cols();
    Eigen::Index kept = 1;
    while (kept < all && gram.values[all - 1 - kept] > 1e-3 * _objective.size())
        ++kept;
    assign(X * gram.vectors.rightCols(kept).rowwise().reverse());
}

Eigen::VectorXcd PhaseRelaxation::round(std::mt19937_64& random) const
{
    Eigen::VectorXcd sum = Eigen::VectorXcd::Zero(_objective.size());
    for (Eigen::Index c = 0; c < _xRe.cols(); ++c)
    {
        const double re = normal(random), im = normal(random);
        const std::complex<double> direction(re, im);
        for (Eigen::Index l = 0; l < sum.size(); ++l)
            sum[l] += direction * std::complex<double>(_xRe(l, c), _xIm(l, c));
    }
    return unitPhases(sum);
}

Eigen::VectorXcd PhaseRelaxation::leadingPhases() const
{
    return unitPhases(vectors().col(0));
}

BoundSearch::BoundSearch(const PhaseObjective& objective,
                         std::uint64_t seed,
                         base::StopToken stop) :
    _objective(objective),
    _stop(std::move(stop)),
    _random(seed)
{
}

void BoundSearch::tryFrom(const Eigen::VectorXcd& start)
{
    Eigen::VectorXcd u = start;
    _objective.descendFast(u, kMaxRounds, kSettledFast, _stop);
    const double value = _objective.descend(u, kMaxRounds, kSettled, _stop);
    if (_starts++ == 0 || value < _bestValue)
    {
        _bestValue = value;
        _best = std::move(u);
    }
}

void BoundSearch::tryRoundings(const PhaseRelaxation& relaxation, int count, int carriedOn)
{
    std::vector<std::pair<double, Eigen::VectorXcd>> candidates;
    candidates.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i)
    {
        Eigen::VectorXcd u = relaxation.round(_random);
        const double value = _objective.descendFast(u, kFirstRounds, 0.0, _stop);
        candidates.emplace_back(value, std::move(u));
    }
    const int kept = std::min(count, carriedOn);
    std::partial_sort(candidates.begin(),
                      candidates.begin() + kept,
                      candidates.end(),
                      [](const auto& a, const auto& b) { return a.first < b.first; });
    for (int i = 0; i < kept; ++i)
        tryFrom(candidates[static_cast<std::size_t>(i)].second);
    _starts += count - kept;
}

} // namespace midair::haptics
