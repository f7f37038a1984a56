#include "haptics/solvers/certificate/Certificate.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Range.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/solvers/LargeMatrix.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <complex>
#include <limits>
#include <utility>
#include <vector>

#include <fmt/format.h>

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

using Clock = std::chrono::steady_clock;

double since_ms(Clock::time_point start)
{
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// Smallest fall per round over trace(M) that the relaxation, minimised in float, resolves.
constexpr double kSmallestFall = 2e-8;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

// Returns a lower bound of the smallest eigenvalue of M - diag y - sigma I if that matrix is proven
// positive definite; otherwise -infinity.
double provenMargin(const Eigen::MatrixXcd& M,
                    const Eigen::VectorXd& y,
                    double sigma,
                    const base::StopToken& stop)
{
    const double n = static_cast<double>(M.cols());
    Eigen::MatrixXcd S = M;
    S.diagonal().real() -= y;
    S.diagonal().real().array() -= sigma;
    const BlockCholesky factor(S, stop);
    constexpr double kNone = -std::numeric_limits<double>::infinity();
    if (!factor.isPositive() || !factor.isFinite()) return kNone;
    // L L* = S + E with |E_kl| <= gamma |l_k| |l_l| and |l_k|^2 = s_kk / (1 - gamma), so |E| <=
    // gamma / (1 - gamma) tr S, gamma = 8 (n + 4) eps: generous for complex arithmetic and any
    // order of summation. The diagonal's two subtractions are rounded to eps of their operands.
    const Eigen::ArrayXd diagonal = M.diagonal().real();
    const double trace = (diagonal.abs() + y.array().abs() + std::abs(sigma)).sum();
    const double gamma = 8.0 * (n + 4.0) * kEpsilon;
    return -(gamma / (1.0 - gamma) + 2.0 * kEpsilon) * trace;
}

// Returns an estimate of the smallest eigenvalue; for large matrices it is a little too low.
double smallestEigenvalue(const Eigen::MatrixXcd& S, const base::StopToken& stop)
{
    constexpr Eigen::Index kAtOnce = 128;
    if (S.cols() <= kAtOnce) return hermitianValues(S)[0];
    constexpr double kTolerance = 1e-8;
    const LeadingPair pair = leadingPair(-S, kTolerance, stop);
    return -pair.value - pair.residual;
}

// K = G G* and p = G q in double, and a bound on the error of K relative to the exact G.
struct Products
{
    Eigen::MatrixXcd K;
    Eigen::VectorXcd p;   // empty without q
    double entries = 0.0; // bound of |error of G| in Frobenius' norm
    double sums = 0.0;    // bound of |K - G G*| in Frobenius' norm
};

// Returns 1 for silent arrays.
double largestGain(const TransducerArray& array)
{
    const double largest = array.gain.size() > 0 ? array.gain.cwiseAbs().maxCoeff() : 1.0;
    return largest > 0.0 ? largest : 1.0;
}

// Returns transducers first .. first + count - 1 as an array with source amplitude 1 and gains of
// at most 1: a certificate depends only on ratios, and neither K nor its trace may leave the range
// of a double.
TransducerArray partOf(const TransducerArray& array, Eigen::Index first, Eigen::Index count)
{
    TransducerArray part = array;
    part.sourceAmplitude_Pa_m = 1.0;
    part.positions = array.positions.middleCols(first, count);
    part.normals = array.normals.middleCols(first, count);
    if (array.phaseOffset_rad.size() > 0)
        part.phaseOffset_rad = array.phaseOffset_rad.segment(first, count);
    if (array.gain.size() > 0) part.gain = array.gain.segment(first, count) / largestGain(array);
    return part;
}

// Returns a bound of the squared error in Frobenius' norm of G for \a part. An entry g D/R e^{-beta
// R} e^{-jkR} has an error of at most g/R times (64 + 8 kR + |offset|) eps: R and kR are right to a
// few eps, of which kR makes a phase, and the directivity, at most 1, is a short sum. A share of a
// reflector is below 3 (1.34 along each side) and right to 5000 eps, so each of K reflectors adds
// at most 3 times its image, or multiplies the direct wave by at most 4.
double errorOfEntries(const Eigen::Matrix3Xd& points, const TransducerArray& part, double k)
{
    const auto K = static_cast<double>(part.reflectors.size());
    double squares = 0.0;
    for (Eigen::Index i = 0; i < part.positions.cols(); ++i)
    {
        const double gain = part.gain.size() > 0 ? part.gain[i] : 1.0;
        const double offset = part.phaseOffset_rad.size() > 0 ? part.phaseOffset_rad[i] : 0.0;
        const auto errorsFrom = [&](const Eigen::Vector3d& place, double ofShares) -> Eigen::ArrayXd
        {
            const Eigen::ArrayXd R = (points.colwise() - place)
                                         .colwise()
                                         .norm()
                                         .transpose()
                                         .array()
                                         .max(kNearestDistance_m);
            return gain * ((64.0 + std::abs(offset) + ofShares) / R + 8.0 * k);
        };
        const Eigen::Vector3d place = part.positions.col(i);
        Eigen::ArrayXd errors = std::pow(4.0, K) * errorsFrom(place, 5000.0 * K);
        for (const Reflector& one : part.reflectors)
            errors += 3.0 * errorsFrom(one.mirrored(place), 5000.0);
        squares += errors.square().sum();
    }
    return squares * kEpsilon * kEpsilon;
}

Products productsOf(const Eigen::Matrix3Xd& points,
                    const TransducerArray& array,
                    const Medium& medium,
                    const Eigen::VectorXcf& q,
                    const base::StopToken& stop)
{
    constexpr Eigen::Index kAtOnce = 128; // transducers: some 50 ms for 1000 points
    const Eigen::Index n = points.cols(), m = array.positions.cols();
    const double k = base::kTwoPi / medium.wavelength(array.frequency_Hz);
    Products products;
    products.K.setZero(n, n);
    if (q.size() != 0) products.p.setZero(n);
    double squares = 0.0;
    for (Eigen::Index first = 0; first < m; first += kAtOnce)
    {
        stop.throwIfRequested();
        const Eigen::Index count = std::min(kAtOnce, m - first);
        const TransducerArray part = partOf(array, first, count);
        const Eigen::MatrixXcd G = referencePropagationMatrix(points, part, medium);
        products.K.selfadjointView<Eigen::Lower>().rankUpdate(G);
        if (q.size() != 0) products.p += G * q.segment(first, count).cast<std::complex<double>>();
        squares += errorOfEntries(points, part, k);
    }
    products.K.diagonal() = products.K.diagonal().real().cast<std::complex<double>>();
    products.K.triangularView<Eigen::StrictlyUpper>() = products.K.adjoint();
    products.entries = std::sqrt(squares);
    // |error of K_kl| <= gamma |g_k| |g_l| with the gamma of a sum of m complex products.
    products.sums = 8.0 * (static_cast<double>(m) + 4.0) * kEpsilon * products.K.trace().real();
    return products;
}

// Makes products of G those of G + o q* / |q|^2 (ControlPoints::outside_Pa).
void addOutside(const Eigen::VectorXcd& outside_Pa,
                const TransducerArray& array,
                const Eigen::VectorXcf& q,
                Products& products)
{
    const Eigen::VectorXcd o = outside_Pa / (array.sourceAmplitude_Pa_m * largestGain(array));
    const double power = q.cast<std::complex<double>>().squaredNorm();
    const Eigen::MatrixXcd mixed = products.p * o.adjoint() / power;
    products.K += mixed + mixed.adjoint() + o * o.adjoint() / power;
    products.K.diagonal() = products.K.diagonal().real().cast<std::complex<double>>();
    products.K.triangularView<Eigen::StrictlyUpper>() = products.K.adjoint();
    products.p += o;
}

// Returns a computed bound minus the effect of rounding in K: see Certificate.h, "Rounding".
double lessRoundingOfK(double bound, const Products& products, double lambda)
{
    const double ofSums = std::max(0.0, 1.0 - products.sums / lambda);
    const double ofEntries = 1.0 + products.entries / std::sqrt(lambda);
    return bound * ofSums / (ofEntries * ofEntries);
}

// Returns a computed bound minus the effect of rounding in M: see Certificate.h, "Rounding".
double lessRoundingOfInverse(double bound, const PhaseObjective& objective)
{
    // |X| <= 1/lambda except for the rounding of K, for which a hundredth is allowed.
    const double wrong = 1.01 * objective.inverseError() * objective.targets().norm();
    const double products = 4.0 * kEpsilon * objective.M().cwiseAbs().sum();
    const double rest = std::max(0.0, bound - products);
    // 4 rest / (..)^2 instead of the difference of two nearly equal roots
    const double root = 2.0 * rest / (wrong + std::sqrt(wrong * wrong + 4.0 * rest));
    return rest > 0.0 ? root * root : 0.0;
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

bool CertificateOptions::isValid(std::string* error) const
{
    return base::RangeCheck("certificate options: ")
        .check(lambdaRel >= PhaseObjective::kSmallestLambdaRel && lambdaRel <= 1e9,
               "lambdaRel",
               lambdaRel,
               "within 1e-5 .. 1e9")
        .within("tolerance", tolerance, 1e-12, 1.0)
        .atLeast("maxRounds", maxRounds, 1)
        .atLeast("batches", batches, 0)
        .passed(error);
}

double
certifiedBound(const Eigen::MatrixXcd& M, const Eigen::VectorXd& y, const base::StopToken& stop)
{
    const double n = static_cast<double>(M.cols());
    Eigen::MatrixXcd S = M;
    S.diagonal().real() -= y;
    // The norm includes the rounding of M - diag y, where all digits may cancel.
    const double norm = S.norm() + 1e-13 * (M.norm() + y.norm());
    const double guess = smallestEigenvalue(S, stop);
    // If no estimate is proven: minus the Frobenius norm is below every eigenvalue, by far more
    // than its rounding.
    double sigma = -(1.0 + 1e-6) * norm;
    double margin = 0.0;
    for (double below = 4.0 * n * kEpsilon * norm; below < norm; below *= 8.0)
    {
        const double proven = provenMargin(M, y, guess - below, stop);
        if (!std::isfinite(proven)) continue;
        sigma = guess - below;
        margin = proven;
        break;
    }
    const double rounding =
        n * kEpsilon * y.cwiseAbs().sum() + 8.0 * (n + 4.0) * kEpsilon * M.cwiseAbs().sum();
    return y.sum() + n * std::min(0.0, sigma + margin) - rounding;
}

Certifier::Certifier(const CertificateOptions& options) : _options(options)
{
    std::string error;
    if (!options.isValid(&error)) throw base::InputError(error);
}

Certificate Certifier::certify(const PhaseObjective& objective, const Eigen::VectorXcd& givenPhases)
{
    if (givenPhases.size() != 0 &&
        (givenPhases.size() != objective.size() || !givenPhases.allFinite()))
        throw base::InputError(fmt::format(
            "certificate: the given phases must be finite, one for each of the {} control points",
            objective.size()));
    if (objective.size() > base::kMostCertifiedPoints)
        throw base::InputError(
            fmt::format("certificate: there are {} control points; at most {} are certified",
                        objective.size(),
                        base::kMostCertifiedPoints));
    const Clock::time_point start = Clock::now();
    Certificate result;
    result.points = objective.size();

    // The fall of a round indicates the distance to the minimum. The bound is proven afterwards, so
    // a poor choice only costs time.
    PhaseRelaxation relaxation(objective, _options.seed, _options.stop);
    double fall = _options.tolerance / 300.0;
    while (!result.tight)
    {
        relaxation.descend(_options.maxRounds, fall);
        result.relaxed = relaxation.value();
        result.bound =
            std::max(result.rounds > 0 ? result.bound : -std::numeric_limits<double>::infinity(),
                     certifiedBound(objective.M(), relaxation.y(), _options.stop));
        result.tight = result.relaxed - result.bound <= _options.tolerance * result.relaxed;
        const bool spent =
            relaxation.rounds() >= _options.maxRounds || relaxation.rounds() == result.rounds;
        result.rounds = relaxation.rounds();
        if (spent || fall < kSmallestFall) break;
        fall *= 0.25;
    }
    // M is positive definite, so a bound below 0 would be meaningless.
    result.bound = lessRoundingOfInverse(std::max(result.bound, 0.0), objective);
    result.bound_ms = since_ms(start);

    const Clock::time_point searchStart = Clock::now();
    relaxation.reduceRank();
    result.rank = relaxation.rank();
    BoundSearch search(objective, _options.seed, _options.stop);
    if (givenPhases.size() != 0)
    {
        result.hasGiven = true;
        const Eigen::VectorXcd u = unitPhases(givenPhases);
        result.givenPhases = objective.value(u);
        search.tryFrom(u);
    }
    for (int batch = 0; batch < _options.batches; ++batch)
        search.tryRoundings(relaxation, kRoundings, kCarriedOn);
    if (search.starts() == 0) search.tryFrom(relaxation.leadingPhases());
    result.phases = search.best();
    result.best = objective.value(result.phases);
    result.starts = search.starts();
    result.search_ms = since_ms(searchStart);
    result.total_ms = since_ms(start);
    return result;
}

Certificate Certifier::certify(const ControlPoints& points,
                               const TransducerArray& array,
                               const Medium& medium,
                               const Eigen::VectorXcf& q)
{
    const Clock::time_point start = Clock::now();
    if (points.size() == 0 || array.size() == 0 || !points.positions.allFinite())
        throw base::InputError("certificate: there must be at least one control point and one "
                               "transducer, at finite places");
    if (points.size() > base::kMostCertifiedPoints)
        throw base::InputError(
            fmt::format("certificate: there are {} control points; at most {} are certified",
                        points.size(),
                        base::kMostCertifiedPoints));
    if (q.size() != 0 && (q.size() != array.size() || !q.allFinite()))
        throw base::InputError(fmt::format(
            "certificate: the activations must be finite, one for each of the {} transducers",
            array.size()));
    if (points.outside_Pa.size() != 0 &&
        (points.outside_Pa.size() != points.size() || !points.outside_Pa.allFinite() ||
         !(q.squaredNorm() > 0.0f)))
        throw base::InputError(fmt::format("certificate: outside pressures must be finite, one for "
                                           "each of the {} control points, and need activations "
                                           "that are not all 0",
                                           points.size()));
    if (points.outsideRows_Pa)
        throw base::InputError("certificate: outside rows are not known here; hand over all that "
                               "they add as outside pressures");
    Products products = productsOf(points.positions, array, medium, q, _options.stop);
    if (points.outside_Pa.size() != 0) addOutside(points.outside_Pa, array, q, products);
    const PhaseObjective objective(products.K, points.targets, _options.lambdaRel, _options.stop);
    const double matrix_ms = since_ms(start);

    Certificate result = certify(objective, products.p);
    result.bound = lessRoundingOfK(result.bound, products, objective.lambda());
    if (result.hasGiven)
        result.givenField =
            objective.misfitAndPower(products.p, q.cast<std::complex<double>>().squaredNorm());
    result.matrix_ms = matrix_ms;
    result.total_ms = since_ms(start);
    return result;
}

} // namespace midair::haptics
