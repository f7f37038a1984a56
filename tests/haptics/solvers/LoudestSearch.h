#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <complex>
#include <random>

/// A slow search for loud exact fields of a few points and transducers, in double and with dense
/// matrices, with nothing of the solver: midair-certificate-bench prints its result, and tests hold
/// the solver to it.
namespace midair::haptics
{

namespace loudest
{

inline Eigen::VectorXcd fieldOf(const Eigen::MatrixXcd& G, const Eigen::VectorXd& phases)
{
    Eigen::VectorXcd q(phases.size());
    for (Eigen::Index i = 0; i < phases.size(); ++i)
        q[i] = std::polar(1.0, phases[i]);
    return G * q;
}

inline Eigen::VectorXd lacks(const Eigen::VectorXcd& p, const Eigen::VectorXd& wanted)
{
    return (p.cwiseAbs().array() / wanted.array()).square() - 1.0;
}

// Levenberg steps on |p_l|^2 = wanted_l^2; returns true if they end at it.
inline bool fit(const Eigen::MatrixXcd& G, const Eigen::VectorXd& wanted, Eigen::VectorXd& phases)
{
    constexpr int kSteps = 60, kTries = 8;
    const Eigen::Index n = G.rows(), m = G.cols();
    double damping = 1e-3;
    for (int k = 0; k < kSteps; ++k)
    {
        const Eigen::VectorXcd p = fieldOf(G, phases);
        const Eigen::VectorXd r = lacks(p, wanted);
        if (r.squaredNorm() < 1e-10) return true;
        Eigen::MatrixXd J(n, m);
        for (Eigen::Index i = 0; i < m; ++i)
            for (Eigen::Index l = 0; l < n; ++l)
                J(l, i) = -2.0 * std::imag(std::conj(p[l]) * G(l, i) * std::polar(1.0, phases[i])) /
                          (wanted[l] * wanted[l]);
        const Eigen::MatrixXd K = J * J.transpose();
        bool isLower = false;
        for (int t = 0; t < kTries && !isLower; ++t)
        {
            const Eigen::MatrixXd damped =
                K + damping * K.trace() / static_cast<double>(n) * Eigen::MatrixXd::Identity(n, n);
            Eigen::VectorXd step = -J.transpose() * damped.ldlt().solve(r);
            step /= std::max(1.0, step.cwiseAbs().maxCoeff());
            isLower = lacks(fieldOf(G, phases + step), wanted).squaredNorm() < r.squaredNorm();
            if (isLower) phases += step;
            damping = isLower ? std::max(0.3 * damping, 1e-9) : 5.0 * damping;
        }
        if (!isLower) return false;
    }
    return false;
}

} // namespace loudest

/// Returns the largest level s of |G q| = s \a targets with |q_i| = 1 that \a starts descents from
/// random phases find (Levenberg 1944), each of which raises s until it fails by less than half a
/// percent; 0 if none fits. \a G: n x m, Pa; \a targets: n, > 0.
inline double
loudestExactLevel(const Eigen::MatrixXcd& G, const Eigen::VectorXd& targets, int starts)
{
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> turn(0.0, 2.0 * M_PI);
    const double focus_Pa = G.cwiseAbs().rowwise().sum().mean();
    double best = 0.0;
    for (int start = 0; start < starts; ++start)
    {
        Eigen::VectorXd phases =
            Eigen::VectorXd::NullaryExpr(G.cols(), [&]() { return turn(random); });
        double level = 0.02 * focus_Pa / targets.norm();
        for (double factor = 1.5; factor > 1.005;)
        {
            Eigen::VectorXd louder = phases;
            if (loudest::fit(G, factor * level * targets, louder))
            {
                phases = louder;
                level *= factor;
                best = std::max(best, level);
            }
            else
                factor = std::sqrt(factor);
        }
    }
    return best;
}

} // namespace midair::haptics
