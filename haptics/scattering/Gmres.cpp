#include "haptics/scattering/Gmres.h"

#include <cmath>
#include <complex>
#include <vector>

namespace midair::haptics
{

namespace
{

using Complex = std::complex<double>;

/// A rotation that makes the second of two numbers zero.
struct Givens
{
    Givens(const Complex& a, const Complex& b)
    {
        const double length = std::hypot(std::abs(a), std::abs(b));
        if (length == 0.0) return;
        c = std::abs(a) / length;
        const Complex direction = a == 0.0 ? Complex(1.0) : a / std::abs(a);
        s = direction * std::conj(b) / length;
        if (a == 0.0) c = 0.0;
    }
    void turn(Complex& a, Complex& b) const
    {
        const Complex first = c * a + s * b;
        b = -std::conj(s) * a + c * b;
        a = first;
    }

    double c = 1.0;
    Complex s = 0.0;
};

/// The Krylov space so far, and the least squares problem in it.
struct Krylov
{
    std::vector<Eigen::VectorXcd> basis;
    std::vector<Eigen::VectorXcd> columns; ///< upper triangular after the rotations
    std::vector<Givens> rotations;
    std::vector<Complex> right; ///< the rotated right-hand side

    /// Adds A times the last vector of the basis, in \a w. Returns false if nothing new is left.
    bool add(Eigen::VectorXcd& w)
    {
        const auto k = static_cast<Eigen::Index>(basis.size());
        Eigen::VectorXcd column(k + 1);
        for (Eigen::Index i = 0; i < k; ++i)
        {
            const Eigen::VectorXcd& v = basis[static_cast<std::size_t>(i)];
            column[i] = v.dot(w);
            w -= column[i] * v;
        }
        const double left = w.norm();
        column[k] = left;
        for (Eigen::Index i = 0; i + 1 < k; ++i)
            rotations[static_cast<std::size_t>(i)].turn(column[i], column[i + 1]);
        const double size = column.norm();
        const Givens last(column[k - 1], column[k]);
        last.turn(column[k - 1], column[k]);
        rotations.push_back(last);
        right.emplace_back(0.0);
        last.turn(right[right.size() - 2], right.back());
        columns.push_back(column);
        if (!(left > 1e-14 * size)) return false;
        basis.push_back(w / left);
        return true;
    }
    Eigen::VectorXcd solution() const
    {
        const std::size_t k = columns.size();
        std::vector<Complex> y(k);
        for (std::size_t i = k; i-- > 0;)
        {
            Complex sum = right[i];
            for (std::size_t j = i + 1; j < k; ++j)
                sum -= columns[j][static_cast<Eigen::Index>(i)] * y[j];
            const Complex pivot = columns[i][static_cast<Eigen::Index>(i)];
            y[i] = pivot == 0.0 ? Complex(0.0) : sum / pivot;
        }
        Eigen::VectorXcd x = Eigen::VectorXcd::Zero(basis.front().size());
        for (std::size_t i = 0; i < k; ++i)
            x += y[i] * basis[i];
        return x;
    }
};

} // namespace

GmresReport gmres(const ComplexOperator& A,
                  const Eigen::VectorXcd& b,
                  Eigen::VectorXcd& x,
                  double tolerance,
                  int mostIterations,
                  const base::StopToken& stop)
{
    GmresReport report;
    x = Eigen::VectorXcd::Zero(b.size());
    const double size = b.norm();
    report.isConverged = size == 0.0;
    if (report.isConverged || !std::isfinite(size)) return report;
    Krylov space;
    space.basis.push_back(b / size);
    space.right.emplace_back(size);
    Eigen::VectorXcd w(b.size());
    bool isNew = true;
    while (isNew && !report.isConverged && report.iterations < mostIterations)
    {
        stop.throwIfRequested();
        A(space.basis.back(), w);
        isNew = space.add(w);
        ++report.iterations;
        report.residual = std::abs(space.right.back()) / size;
        report.isConverged = report.residual <= tolerance;
    }
    x = space.solution();
    return report;
}

} // namespace midair::haptics
