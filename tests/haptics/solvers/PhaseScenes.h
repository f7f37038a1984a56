#pragma once

#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/solvers/PhaseObjective.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <cmath>
#include <complex>
#include <random>

namespace midair::haptics
{

/// u* M u of points in the octagonal prism.
inline PhaseObjective prismObjective(const ControlPoints& points, double lambdaRel = 0.1)
{
    const Eigen::MatrixXcd G =
        referencePropagationMatrix(points.positions, TransducerArray::octagonalPrism(), Medium());
    return {gramMatrix(G), points.targets, lambdaRel};
}

inline Eigen::VectorXcd randomPhases(int n, std::mt19937_64& random)
{
    std::uniform_real_distribution<double> turn(0.0, 2.0 * M_PI);
    Eigen::VectorXcd u(n);
    for (std::complex<double>& z : u)
        z = std::polar(1.0, turn(random));
    return u;
}

inline Eigen::MatrixXcd randomMatrix(int rows, int columns, std::mt19937_64& random)
{
    std::normal_distribution<double> normal;
    Eigen::MatrixXcd A(rows, columns);
    for (std::complex<double>& z : A.reshaped())
        z = {normal(random), normal(random)};
    return A;
}

} // namespace midair::haptics
