#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"

#include <Eigen/Core>

#include <complex>
#include <vector>

namespace midair::haptics
{

/// Returns G in double precision, directly from the formula; the reference for tests of the fast
/// code.
///     G_li = P0 gain_i D(theta_li) / R_li exp(-(beta + j k) R_li + j phaseOffset_i)
/// (Inoue, Makino, Shinoda 2015, equations 2 to 5; time factor e^{+j omega t}). n x m, Pa peak at
/// full drive. R_li is at least kNearestDistance_m, and cos(theta_li) = (r_l - r_i).n_i / R_li, so
/// G is finite everywhere. The array's reflectors add and take away what Reflections.h says.
Eigen::MatrixXcd referencePropagationMatrix(const Eigen::Matrix3Xd& points,
                                            const TransducerArray& array,
                                            const Medium& medium);

/// One way of sound from a transducer to a point.
struct SoundPath
{
    int transducer;
    double length_m;
    std::complex<double> entry; ///< its part of G
};

/// Returns all ways to \a point: for each transducer the direct one, then those by reflectors. The
/// entries of a transducer add up to its entry of G.
std::vector<SoundPath>
referencePaths(const Eigen::Vector3d& point, const TransducerArray& array, const Medium& medium);

} // namespace midair::haptics
