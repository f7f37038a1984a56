#pragma once

#include "haptics/base/threads/ThreadPool.h"

#include <Eigen/Core>

#include <cmath>
#include <complex>

namespace midair::haptics::scattering
{

using Complex = std::complex<double>;

constexpr double kInverse4Pi = 0.079577471545947667884;

/// G = e^{-jkr} / 4 pi r.
inline Complex green(double k, double r)
{
    return std::polar(kInverse4Pi / r, -k * r);
}

/// The derivative of G along the unit vector \a normal at the source; \a d from the source to the
/// point.
inline Complex greenSlope(double k, const Eigen::Vector3d& d, const Eigen::Vector3d& normal)
{
    const double r = d.norm();
    return Complex(1.0 / r, k) * green(k, r) * (d.dot(normal) / r);
}

/// Returns \a field at each of \a points, on \a threads threads.
template<typename Field>
Eigen::VectorXcd atEach(const Eigen::Matrix3Xd& points, int threads, const Field& field)
{
    Eigen::VectorXcd all(points.cols());
    base::ThreadPool pool(threads);
    pool.run(
        [&](int thread)
        {
            for (Eigen::Index p = thread; p < points.cols(); p += threads)
                all[p] = field(Eigen::Vector3d(points.col(p)));
        });
    return all;
}

} // namespace midair::haptics::scattering
