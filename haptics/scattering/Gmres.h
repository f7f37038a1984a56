#pragma once

#include "haptics/base/threads/StopToken.h"

#include <Eigen/Core>

#include <functional>

namespace midair::haptics
{

/// y = A x for square A; y has the size of x.
using ComplexOperator = std::function<void(const Eigen::VectorXcd& x, Eigen::VectorXcd& y)>;

struct GmresReport
{
    int iterations = 0;
    double residual = 0.0; ///< |b - A x| / |b|
    bool isConverged = false;
};

/// Solves A x = b by GMRES without restarts (Saad, Schultz 1986, 10.1137/0907058), from x = 0 until
/// |b - A x| <= \a tolerance |b|, for at most \a mostIterations. Keeps a vector of b's size for
/// each iteration. b = 0 gives x = 0. Throws Stopped if \a stop requests it.
GmresReport gmres(const ComplexOperator& A,
                  const Eigen::VectorXcd& b,
                  Eigen::VectorXcd& x,
                  double tolerance,
                  int mostIterations,
                  const base::StopToken& stop = {});

} // namespace midair::haptics
