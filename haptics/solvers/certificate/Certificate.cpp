#include "haptics/solvers/certificate/Certificate.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/text/Range.h"
#include "haptics/solvers/LargeMatrix.h"
#include "haptics/solvers/certificate/PhaseRelaxation.h"

#include <Eigen/Eigenvalues>

#include <chrono>
#include <cmath>
#include <complex>
#include <limits>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

using Clock = std::chrono::steady_clock;

double since_ms(Clock::time_point start)
{
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// Least fall per round over trace(M) that the relaxation, which is minimised in float, resolves.
constexpr double kSmallestFall = 2e-8;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

// Returns a lower bound of the smallest eigenvalue of M - diag y - sigma I if that matrix is found
// positive definite; else -infinity.
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
    if (S.cols() <= kAtOnce)
        return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXcd>(S, Eigen::EigenvaluesOnly)
            .eigenvalues()[0];
    constexpr double kTolerance = 1e-8;
    const LeadingPair pair = leadingPair(-S, kTolerance, stop);
    return -pair.value - pair.residual;
}

// Returns p = G q.
Eigen::VectorXcd pressures(const PropagationMatrix& G, const Eigen::VectorXcf& q)
{
    const auto padded = static_cast<std::size_t>(G.paddedTransducers());
    base::AlignedBuffer<float> re, im;
    re.reserve(padded);
    im.reserve(padded);
    for (std::size_t lane = 0; lane < G.order().size(); ++lane)
    {
        re[lane] = q[G.order()[lane]].real();
        im[lane] = q[G.order()[lane]].imag();
    }
    Eigen::VectorXf pRe = Eigen::VectorXf::Zero(G.points()), pIm = pRe;
    for (int block = 0; block < G.blocks(); ++block)
        G.forward(block, re.data(), im.data(), pRe.data(), pIm.data());
    Eigen::VectorXcd p(G.points());
    p.real() = pRe.cast<double>();
    p.imag() = pIm.cast<double>();
    return p;
}

} // namespace

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
    // If no estimate is proved: minus the Frobenius norm is below every eigenvalue, by far more
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

    // The fall of a round tells how far the minimum is. The bound is proved afterwards, so a poor
    // choice only costs time.
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
    // M is positive definite, so a bound below 0 would say nothing.
    result.bound = std::max(result.bound, 0.0);
    result.bound_ms = since_ms(start);

    const Clock::time_point searchStart = Clock::now();
    relaxation.reduceRank();
    result.rank = relaxation.rank();
    PhaseSearch search(objective, _options.seed, _options.stop);
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
    _propagation.bind(array, medium);
    _options.stop.throwIfRequested();
    _propagation.build(points.positions);
    const PhaseObjective objective(
        gramMatrix(_propagation, _options.stop), points.targets, _options.lambdaRel, _options.stop);
    const Eigen::VectorXcd p = q.size() != 0 ? pressures(_propagation, q) : Eigen::VectorXcd();
    const double matrix_ms = since_ms(start);

    Certificate result = certify(objective, p);
    if (result.hasGiven)
        result.givenField =
            objective.misfitAndPower(p, q.cast<std::complex<double>>().squaredNorm());
    result.matrix_ms = matrix_ms;
    result.total_ms = since_ms(start);
    return result;
}

} // namespace midair::haptics
