#pragma once

#include "haptics/base/threads/StopToken.h"
#include "haptics/points/ControlPoints.h"

#include <Eigen/Core>

#include <array>

namespace midair::haptics
{

/// Spacings, in wavelengths, for samples of a surface whose pressure is evened out: the first that
/// gives at most kMostPlaces. SOLVER.md, "Fields in turn".
constexpr std::array<double, 3> kPlaceSpacings{0.22, 0.27, 0.33};
constexpr int kMostPlaces = 5000;

/// In spacings of control points: the farthest that the sampler leaves a place of the surface from
/// a point.
constexpr double kFeltReach = 1.1;

/// Returns those of \a samples (3 x n, metres) within \a reach_m of one of \a points, each with the
/// target of the nearest: the part of a surface that should be felt, and how strong. Throws
/// base::Stopped if \a stop requests it.
ControlPoints feltPlaces(const Eigen::Matrix3Xd& samples,
                         const ControlPoints& points,
                         double reach_m,
                         const base::StopToken& stop = {});

} // namespace midair::haptics
