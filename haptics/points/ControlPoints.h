#pragma once

#include "haptics/base/threads/StopToken.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace midair::haptics
{

/// Control points in the array frame; n points, all members of the same length.
struct ControlPoints
{
    Eigen::Matrix3Xd positions; ///< 3 x n, metres
    Eigen::Matrix3Xd normals;   ///< 3 x n, unit length, pointing out of the object
    /// n, >= 0: requested peak pressure; 0: the point is left out.
    Eigen::VectorXd targets;
    /// True: targets are in Pa. False: only their ratios count, and the array plays as loud as the
    /// field stays accurate.
    bool absolute = false;
    std::vector<int> object; ///< n or empty: index of the object each point belongs to
    /// n or empty: stable number of a place on an object, so that a solver can continue when points
    /// come and go.
    std::vector<std::uint64_t> identity;
    /// n or empty: complex peak pressure, Pa, that things outside the model of the array add to the
    /// field of the drive q0 which a solver is passed as q (m, not silent): of an application's own
    /// scattering model S, o = S q0. Fields q are then solved for
    ///     p = G q + o (q0* q) / |q0|^2,
    /// which is G q0 + o for q0, and follows the level and the common phase of q, as what scatters
    /// does. Calls in turn, each with o of the last q, end at |G q + S q| = s a.
    Eigen::VectorXcd outside_Pa;
    /// Null, or n x m: complex peak pressure, Pa, that such things add for each activation, as far
    /// as a model of theirs is known as a matrix R. G becomes G + R; outside_Pa then has only what
    /// R has not.
    std::shared_ptr<const Eigen::MatrixXcf> outsideRows_Pa;

    int size() const { return static_cast<int>(positions.cols()); }
};

/// Returns the points with the indices \a chosen, in that order.
ControlPoints pick(const ControlPoints& points, const std::vector<int>& chosen);

/// Appends \a more to \a to. Missing normals become zeros; objects and identities are kept only if
/// both have them. Missing outside pressures are 0. `absolute` comes from the one that has points.
void append(ControlPoints& to, const ControlPoints& more);

/// Spacings, in wavelengths, of surface samples for evening out: the first that gives at most
/// kMostPlaces is used. SOLVER.md, "Fields in turn".
constexpr std::array<double, 3> kPlaceSpacings{0.22, 0.27, 0.33};
constexpr int kMostPlaces = 5000;

/// In spacings of control points: the largest distance from a place of the surface to the nearest
/// sampled point.
constexpr double kFeltReach = 1.1;

/// Returns those of \a samples (3 x n, metres) within \a reach_m of one of \a points, each with the
/// target of the nearest point: the touchable part of a surface. Throws base::Stopped if \a stop
/// requests it.
ControlPoints feltPlaces(const Eigen::Matrix3Xd& samples,
                         const ControlPoints& points,
                         double reach_m,
                         const base::StopToken& stop = {});

} // namespace midair::haptics
