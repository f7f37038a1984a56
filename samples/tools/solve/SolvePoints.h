#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/surface/Outline.h"
#include "haptics/surface/TriangleMesh.h"
#include "samples/tools/solve/SolveOptions.h"

#include <Eigen/Geometry>

#include <vector>

namespace midair::samples
{

/// Input of a solve: the array, the air and the model.
struct SolveScene
{
    haptics::TransducerArray array;
    haptics::Medium medium;
    haptics::TriangleMesh mesh; ///< metres; empty if the points come from a file
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity(); ///< mesh -> array

    double wavelength_m() const { return medium.wavelength(array.frequency_Hz); }
};

/// Loads the array, air and model that \a arguments name. Throws base::InputError.
SolveScene loadScene(const SolveArguments& arguments);

/// Returns control points in the array frame, a set for each field of a cycle. Points that the
/// array can't reach are left out, with a message on standard error. Throws base::InputError.
std::vector<haptics::ControlPoints> pointSets(const SolveArguments& arguments,
                                              const SolveScene& scene);

/// Returns the model's feature edges in the array frame, with the wanted pressure or 1 as targets.
/// Edges that are not entirely within the array's reach are left out, with a message; \a any is
/// true if the model has edges. Throws base::InputError.
std::vector<haptics::Outline>
modelOutlines(const SolveArguments& arguments, const SolveScene& scene, bool& any);

/// Returns the places near \a points where fields in turn are evened out, with their targets; none,
/// with a message, if the surface is too large.
haptics::ControlPoints placesToEven(const SolveArguments& arguments,
                                    const haptics::ControlPoints& points,
                                    const SolveScene& scene);

/// Returns samples of the felt surface near \a points (3 x n), at most a fifth of a wavelength
/// apart.
Eigen::Matrix3Xd feltSurface(const SolveArguments& arguments,
                             const Eigen::Matrix3Xd& points,
                             const SolveScene& scene);

} // namespace midair::samples
