#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"

#include <Eigen/Core>

namespace midair::haptics
{

/// Returns G in double precision, directly from the formula; the reference for tests of the fast
/// code.
///     G_li = P0 gain_i D(theta_li) / R_li exp(-(beta + j k) R_li + j phaseOffset_i)
/// (Inoue, Makino, Shinoda 2015, equations 2 to 5; time factor e^{+j omega t}). n x m, Pa peak at
/// full drive. R_li is at least kNearestDistance_m, and cos(theta_li) = (r_l - r_i).n_i / R_li, so
/// G is finite everywhere.
Eigen::MatrixXcd referencePropagationMatrix(const Eigen::Matrix3Xd& points,
                                            const TransducerArray& array,
                                            const Medium& medium);

} // namespace midair::haptics
