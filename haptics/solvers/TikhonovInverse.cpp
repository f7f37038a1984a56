#include "haptics/solvers/TikhonovInverse.h"

#include "haptics/solvers/LargeMatrix.h"
#include "haptics/solvers/PhaseObjective.h"

#include <algorithm>

namespace midair::haptics
{

namespace
{

// Below this share of trace(K)/n eigenvalues of K are noise, as its products are in float.
constexpr double kSmallestLambdaRel = 1e-6;
// Above this lambda, G^- is proportional to G*.
constexpr double kLargestLambdaRel = 1e6;

} // namespace

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
