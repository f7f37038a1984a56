#pragma once

#include "haptics/array/TransducerArray.h"

#include <Eigen/Core>

#include <utility>
#include <vector>

namespace midair::haptics
{

/// A flat board whose transducers all face the same way: what arrays are put together from.
struct Board
{
    Eigen::Vector3d position = Eigen::Vector3d::Zero();      ///< metres: where place (0, 0) is
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();       ///< unit length: direction of emission
    Eigen::Vector3d columnsAlong = Eigen::Vector3d::UnitX(); ///< unit length, across the normal
    std::vector<Eigen::Vector2d> places; ///< metres along columnsAlong and normal x columnsAlong
};

/// Places of a grid round (0, 0), column by column within row by row; \a without are the (column,
/// row), from 1, that are left out. \a pitch_m > 0.
std::vector<Eigen::Vector2d>
gridPlaces(int columns, int rows, double pitch_m, const std::vector<std::pair<int, int>>& without);

/// A direction for columns that suits \a normal (unit length): level, so that rows run up along +y
/// as far as they can; +x for a board that faces along y.
Eigen::Vector3d levelColumns(const Eigen::Vector3d& normal);

/// Appends the transducers of \a board to \a array, in the order of its places, as one more board.
void appendBoard(const Board& board, TransducerArray& array);

} // namespace midair::haptics
