#pragma once

#include "haptics/boards/BoardSolver.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::haptics
{

/// Points within this of a plane or a line don't tell its sides apart, m.
constexpr double kFlat_m = 3e-3;

/// Returns how far, rms, \a places are from their best plane (first) and from their best line, m,
/// and the plane's normal.
Eigen::Vector2d flatness(const Eigen::Matrix3Xd& places, Eigen::Vector3d& normal);

/// Returns the measurements in \a used (0, 1) that \a board is in.
std::vector<int> measurementsOf(int board,
                                const BoardSolver& solver,
                                const BoardMeasurements& measurements,
                                const std::vector<char>& used);

/// Returns a sentence for each board that could as well be on the other side of a plane, since what
/// it is measured to is in one: it is reflected and fitted from there, and found to fit as well.
std::vector<std::string> mirrorNotes(const BoardSolver& solver,
                                     const BoardMeasurements& measurements,
                                     const std::vector<char>& used,
                                     double sigma_m,
                                     const BoardState& state);

} // namespace midair::haptics
