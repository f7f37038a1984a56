#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/surface/Outline.h"
#include "haptics/surface/TriangleMesh.h"
#include "samples/solve/SolveOptions.h"

#include <Eigen/Geometry>

#include <vector>

namespace midair::samples
{

/// What is to be felt, and in which array.
struct SolveScene
{
    haptics::TransducerArray array;
    haptics::Medium medium;
    haptics::TriangleMesh mesh; ///< metres; empty where the points come from a file
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity(); ///< mesh -> array

    double wavelength_m() const { return medium.wavelength(array.frequency_Hz); }
};

/// Array, air and model that \a arguments name. Throws base::InputError.
SolveScene loadScene(const SolveArguments& arguments);

/// Control points in the array frame, a set for each field of a cycle; what the array can't reach
/// is left out and told on standard error. Throws base::InputError.
std::vector<haptics::ControlPoints> pointSets(const SolveArguments& arguments,
                                              const SolveScene& scene);

/// The model's feature edges in the array frame, their targets the pressure asked for or 1. Those
/// that are not whole within the array's reach are left out and told; \a any says whether there
/// were some. Throws base::InputError.
std::vector<haptics::Outline>
modelOutlines(const SolveArguments& arguments, const SolveScene& scene, bool& any);

/// Samples of what is to be felt, a fifth of a wavelength apart at most, near \a points (3 x n).
Eigen::Matrix3Xd feltSurface(const SolveArguments& arguments,
                             const Eigen::Matrix3Xd& points,
                             const SolveScene& scene);

} // namespace midair::samples
