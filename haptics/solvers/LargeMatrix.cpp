#include "haptics/solvers/LargeMatrix.h"

#include "haptics/solvers/PhaseObjective.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <random>

namespace midair::haptics
{

namespace
{

// Largest matrix handled in a single step: a factorisation takes 1 ms, a decomposition 20 ms.
constexpr Eigen::Index kSmall = 128;
// Columns between two checks for a stop request: with 1000 rows they take about 30 ms.
constexpr Eigen::Index kStep = 32;
constexpr Eigen::Index kLanczosSteps = 60;
constexpr int kRestarts = 60;

Eigen::VectorXcd startingVector(Eigen::Index n)
{
    std::mt19937_64 random(1);
    const auto uniform = [&random]
    { return 2.0 * (static_cast<double>(random() >> 11U) * 0x1p-53) - 1.0; };
    Eigen::VectorXcd v(n);
    for (std::complex<double>& value : v)
    {
        const double re = uniform();
        value = {re, uniform()};
    }
    return v.normalized();
}

/// Runs Lanczos from \a pair.vector (Golub, Van Loan, "Matrix computations", 10.1), orthogonalising
/// every vector against all previous ones.
void improve(const Eigen::MatrixXcd& A, LeadingPair& pair, const base::StopToken& stop)
{
    const Eigen::Index most = std::min(kLanczosSteps, A.cols());
    Eigen::MatrixXcd V(A.cols(), most);
    Eigen::VectorXd diagonal(most), below(most);
    V.col(0) = pair.vector;
    Eigen::VectorXcd w;
    Eigen::Index steps = 0;
    while (steps < most)
    {
        stop.throwIfRequested();
        w.noalias() = A * V.col(steps);
        diagonal[steps] = V.col(steps).dot(w).real();
        const double size = w.norm();
        for (int pass = 0; pass < 2; ++pass)
            w -= (V.leftCols(steps + 1) * (V.leftCols(steps + 1).adjoint() * w)).eval();
        below[steps] = w.norm();
        ++steps;
        if (steps == most || !(below[steps - 1] > 1e-14 * size)) break;
        V.col(steps) = w / below[steps - 1];
    }
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz;
    ritz.computeFromTridiagonal(diagonal.head(steps), below.head(steps - 1));
    pair.vector = (V.leftCols(steps) * ritz.eigenvectors().col(steps - 1)).normalized();
    w.noalias() = A * pair.vector;
    pair.value = pair.vector.dot(w).real();
    pair.residual = (w - pair.value * pair.vector).norm();
}

// Below this share of trace(K)/n eigenvalues of K are noise, because its products are in float.
constexpr double kSmallestLambdaRel = 1e-6;
// Above this lambda, G^- is proportional to G*.
constexpr double kLargestLambdaRel = 1e6;

} // namespace

bool BlockCholesky::compute(Eigen::MatrixXcd A, const base::StopToken& stop)
{
    _lower = std::move(A);
    const Eigen::Index n = _lower.cols(), width = n <= kSmall ? n : kStep;
    _positive = true;
    for (Eigen::Index k = 0; k < n && _positive; k += width)
    {
        stop.throwIfRequested();
        const Eigen::Index w = std::min(width, n - k), rest = n - k - w;
        auto corner = _lower.block(k, k, w, w);
        const Eigen::LLT<Eigen::Ref<Eigen::MatrixXcd>> factor(corner);
        _positive = factor.info() == Eigen::Success;
        if (!_positive || rest == 0) continue;
        auto panel = _lower.block(k + w, k, rest, w);
        corner.adjoint().triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(panel);
        _lower.bottomRightCorner(rest, rest)
            .selfadjointView<Eigen::Lower>()
            .rankUpdate(panel, std::complex<double>(-1.0));
    }
    return _positive;
}

bool BlockCholesky::isFinite() const
{
    return _lower.triangularView<Eigen::Lower>().toDenseMatrix().allFinite();
}

Eigen::MatrixXcd BlockCholesky::inverse(const base::StopToken& stop) const
{
    const Eigen::Index n = _lower.cols(), width = n <= kSmall ? n : kStep;
    Eigen::MatrixXcd result = Eigen::MatrixXcd::Identity(n, n);
    for (Eigen::Index k = 0; k < n; k += width)
    {
        stop.throwIfRequested();
        auto columns = result.middleCols(k, std::min(width, n - k));
        _lower.triangularView<Eigen::Lower>().solveInPlace(columns);
        stop.throwIfRequested();
        _lower.adjoint().triangularView<Eigen::Upper>().solveInPlace(columns);
    }
    return result;
}

Eigen::VectorXcd BlockCholesky::solve(const Eigen::VectorXcd& b) const
{
    Eigen::VectorXcd x = b;
    _lower.triangularView<Eigen::Lower>().solveInPlace(x);
    _lower.adjoint().triangularView<Eigen::Upper>().solveInPlace(x);
    return x;
}

HermitianAxes hermitianAxes(const Eigen::MatrixXcd& A)
{
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXcd> solver(A);
    return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::VectorXd hermitianValues(const Eigen::MatrixXcd& A)
{
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXcd>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

LeadingPair leadingPair(const Eigen::MatrixXcd& A, double tolerance, const base::StopToken& stop)
{
    LeadingPair pair;
    if (A.cols() <= kSmall)
    {
        const HermitianAxes axes = hermitianAxes(A);
        pair.value = axes.values[A.cols() - 1];
        pair.vector = axes.vectors.col(A.cols() - 1);
        return pair;
    }
    pair.vector = startingVector(A.cols());
    const double norm = A.norm();
    for (int restart = 0; restart < kRestarts; ++restart)
    {
        improve(A, pair, stop);
        if (!(pair.residual > tolerance * norm)) break;
    }
    return pair;
}

TikhonovInverse::TikhonovInverse(const FieldProblem& field, double lambdaRel)
{
    const int n = field.n();
    Eigen::MatrixXcd K = gramMatrix(field.G, field.stop());
    const double unit = K.trace().real() / n;
    _lambda = std::clamp(lambdaRel, kSmallestLambdaRel, kLargestLambdaRel) * unit;
    K.diagonal().array() += _lambda;
    BlockCholesky cholesky(K, field.stop());
    while (!cholesky.isPositive())
    {
        K.diagonal().array() += 9.0 * _lambda;
        _lambda *= 10.0;
        cholesky.compute(K, field.stop());
    }
    _inverse = cholesky.inverse(field.stop());
}

Eigen::MatrixXcd TikhonovInverse::projector() const
{
    return Eigen::MatrixXcd::Identity(_inverse.rows(), _inverse.cols()) - _lambda * _inverse;
}

Eigen::MatrixXcd TikhonovInverse::objective(const Eigen::VectorXf& a) const
{
    const auto A = a.cast<double>().asDiagonal();
    return _lambda * (A * _inverse * A);
}

void TikhonovInverse::play(FieldProblem& field, const Eigen::VectorXcd& u) const
{
    const Eigen::VectorXcd target = field.a.cast<std::complex<double>>().cwiseProduct(u);
    const Eigen::VectorXcd w = _inverse * target;
    const double scale = w.cwiseAbs().maxCoeff();
    for (int l = 0; l < field.n(); ++l)
    {
        const auto row = static_cast<std::size_t>(l);
        field.w.set(row, std::complex<float>(w[l] / scale));
        field.u.set(row, std::complex<float>(u[l]));
    }
    field.backward(field.w, field.q);
}

} // namespace midair::haptics
