#include "haptics/solvers/PhaseObjective.h"

#include "haptics/base/InputError.h"
#include "haptics/propagation/PropagationMatrix.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

constexpr double kLargestObjectiveLambdaRel = 1e9;

void mirrorLowerTriangle(Eigen::MatrixXcd& A)
{
    for (Eigen::Index l = 0; l < A.cols(); ++l)
    {
        A(l, l) = A(l, l).real();
        for (Eigen::Index k = l + 1; k < A.rows(); ++k)
            A(l, k) = std::conj(A(k, l));
    }
}

void checkInput(const Eigen::MatrixXcd& K, const Eigen::VectorXd& targets, double lambdaRel)
{
    const Eigen::Index n = K.cols();
    if (n == 0 || K.rows() != n)
        throw base::InputError(fmt::format(
            "phase objective: K is {} x {}; it must be square and not empty", K.rows(), n));
    if (targets.size() != n)
        throw base::InputError(
            fmt::format("phase objective: {} targets for {} control points", targets.size(), n));
    if (!targets.allFinite() || targets.minCoeff() < 0.0 || !(targets.maxCoeff() > 0.0))
        throw base::InputError(
            "phase objective: targets must be finite and at least 0, one of them more");
    if (!(lambdaRel >= PhaseObjective::kSmallestLambdaRel &&
          lambdaRel <= kLargestObjectiveLambdaRel))
        throw base::InputError(fmt::format(
            "phase objective: lambdaRel is {:g}; it must be from 1e-5 to 1e9", lambdaRel));
    if (!K.allFinite() || !(K.trace().real() > 0.0))
        throw base::InputError(
            "phase objective: K is not finite or zero; no transducer reaches a control point");
}

// Returns an upper bound of |I - X A| in Frobenius norm. A sum of n complex products is exact to 8
// (n + 4) eps of the sum of their moduli, which is at most |x_k| |a_l| for entry kl.
double
errorOfInverse(const Eigen::MatrixXcd& X, const Eigen::MatrixXcd& A, const base::StopToken& stop)
{
    constexpr Eigen::Index kAtOnce = 64; // columns between two checks for a stop request
    const Eigen::Index n = A.cols();
    double squares = 0.0;
    for (Eigen::Index first = 0; first < n; first += kAtOnce)
    {
        stop.throwIfRequested();
        const Eigen::Index count = std::min(kAtOnce, n - first);
        Eigen::MatrixXcd residual = X * A.middleCols(first, count);
        residual.diagonal(-first).array() -= 1.0;
        squares += residual.squaredNorm();
    }
    const double gamma =
        8.0 * (static_cast<double>(n) + 4.0) * std::numeric_limits<double>::epsilon();
    return std::sqrt(squares) + gamma * X.norm() * A.norm();
}

// Over-relaxation: each phase moves beyond its minimum by two thirds of the step, which takes a
// third of the rounds (measured, n = 50 to 200).
constexpr double kSearchOver = 0.65;

template<typename T>
double descendPhases(const kernels::HermitianView<T>& M,
                     Eigen::VectorXcd& u,
                     int maxRounds,
                     double fall,
                     T smallest,
                     const base::StopToken& stop)
{
    using Vector = Eigen::Matrix<T, Eigen::Dynamic, 1>;
    Vector xRe = Vector::Zero(M.stride), xIm = xRe, sRe = xRe, sIm = xRe;
    xRe.head(M.n) = u.real().cast<T>();
    xIm.head(M.n) = u.imag().cast<T>();
    kernels::multiplyMatrix(M, xRe.data(), xIm.data(), sRe.data(), sIm.data());
    for (int round = 0; round < maxRounds; ++round)
    {
        stop.throwIfRequested();
        const double fell = kernels::descendOnce(
            M, 1, T(kSearchOver), smallest, xRe.data(), xIm.data(), sRe.data(), sIm.data());
        if (!(fell > fall)) break;
    }
    for (Eigen::Index l = 0; l < u.size(); ++l)
        u[l] = std::complex<double>(xRe[l], xIm[l]);
    u = u.cwiseQuotient(u.cwiseAbs().cast<std::complex<double>>()).eval();
    return static_cast<double>(xRe.dot(sRe) + xIm.dot(sIm));
}

} // namespace

Eigen::MatrixXcd gramMatrix(const Eigen::MatrixXcd& G)
{
    Eigen::MatrixXcd K = Eigen::MatrixXcd::Zero(G.rows(), G.rows());
    K.selfadjointView<Eigen::Lower>().rankUpdate(G);
    mirrorLowerTriangle(K);
    return K;
}

Eigen::MatrixXcd gramMatrix(const PropagationMatrix& G, const base::StopToken& stop)
{
    const int n = G.points();
    Eigen::MatrixXd re = Eigen::MatrixXd::Zero(n, n), im = re;
    for (int block = 0; block < G.blocks(); ++block)
    {
        stop.throwIfRequested();
        kernels::addGram(G.blockData(block), n, G.width(block), n, re.data(), im.data());
    }
    Eigen::MatrixXcd K(n, n);
    K.real() = re;
    K.imag() = im;
    mirrorLowerTriangle(K);
    return K;
}

PhaseObjective::PhaseObjective(Eigen::MatrixXcd K,
                               const Eigen::VectorXd& targets,
                               double lambdaRel,
                               const base::StopToken& stop) :
    _a(targets)
{
    checkInput(K, targets, lambdaRel);
    const Eigen::Index n = K.cols();
    _lambda = lambdaRel * K.trace().real() / static_cast<double>(n);
    K.diagonal().array() += _lambda;
    if (!_factor.compute(K, stop))
        throw base::InputError("phase objective: K is not positive semidefinite");
    _matrix = _factor.inverse(stop);
    mirrorLowerTriangle(_matrix);
    _inverseError = errorOfInverse(_matrix, K, stop);
    _matrix = _lambda * (_a.asDiagonal() * _matrix * _a.asDiagonal());
    mirrorLowerTriangle(_matrix);
    _trace = _matrix.trace().real();

    const Eigen::Index stride =
        (n + kernels::kPhaseLanes - 1) / kernels::kPhaseLanes * kernels::kPhaseLanes;
    _re = Eigen::MatrixXd::Zero(stride, n);
    _im = Eigen::MatrixXd::Zero(stride, n);
    _re.topRows(n) = _matrix.real();
    _im.topRows(n) = _matrix.imag();
    const double scale = static_cast<double>(n) / _trace;
    _fastRe = (_re * scale).cast<float>();
    _fastIm = (_im * scale).cast<float>();
}

kernels::HermitianView<double> PhaseObjective::view() const
{
    return {size(), static_cast<int>(_re.rows()), _re.data(), _im.data()};
}

kernels::HermitianView<float> PhaseObjective::fastView() const
{
    return {size(), static_cast<int>(_fastRe.rows()), _fastRe.data(), _fastIm.data()};
}

double PhaseObjective::value(const Eigen::VectorXcd& u) const
{
    return u.dot(_matrix * u).real();
}

Eigen::VectorXd PhaseObjective::gradient(const Eigen::VectorXcd& u) const
{
    return 2.0 * (u.conjugate().array() * (_matrix * u).array()).imag();
}

double PhaseObjective::descend(Eigen::VectorXcd& u,
                               int maxRounds,
                               double tolerance,
                               const base::StopToken& stop) const
{
    return descendPhases(view(), u, maxRounds, tolerance * _trace, 1e-9, stop);
}

double PhaseObjective::descendFast(Eigen::VectorXcd& u,
                                   int maxRounds,
                                   double tolerance,
                                   const base::StopToken& stop) const
{
    return descendPhases(fastView(), u, maxRounds, tolerance * size(), 1e-4f, stop) * _trace /
           size();
}

Eigen::VectorXcd PhaseObjective::weights(const Eigen::VectorXcd& u) const
{
    return _factor.solve(_a.asDiagonal() * u);
}

double PhaseObjective::misfitAndPower(const Eigen::VectorXcd& p, double power) const
{
    const double wanted = _a.dot(p.cwiseAbs());
    const double cost = p.squaredNorm() + _lambda * power;
    return _a.squaredNorm() - (cost > 0.0 ? wanted * wanted / cost : 0.0);
}

} // namespace midair::haptics
