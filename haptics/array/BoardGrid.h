#pragma once

#include "haptics/array/TransducerArray.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <utility>
#include <vector>

namespace midair::haptics
{

/// Flat board whose transducers all face the same direction. Arrays consist of boards.
struct Board
{
    Eigen::Vector3d position = Eigen::Vector3d::Zero();      ///< metres: position of place (0, 0)
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();       ///< unit length: direction of emission
    Eigen::Vector3d columnsAlong = Eigen::Vector3d::UnitX(); ///< unit length, across the normal
    std::vector<Eigen::Vector2d> places; ///< metres along columnsAlong and normal x columnsAlong
};

/// Returns the places of a grid centred on (0, 0), row by row. \a without: places (column, row),
/// counted from 1, to leave out. \a pitch_m > 0.
std::vector<Eigen::Vector2d>
gridPlaces(int columns, int rows, double pitch_m, const std::vector<std::pair<int, int>>& without);

/// Returns the column direction of a board with \a normal (unit length): perpendicular to y, so
/// that the row direction is as close to +y as possible; +x for a board that faces along y.
Eigen::Vector3d levelColumns(const Eigen::Vector3d& normal);

/// Appends the transducers of \a board to \a array as a new board, in the order of its places.
void appendBoard(const Board& board, TransducerArray& array);

/// Consecutive transducers of one board: first index and count.
struct BoardRange
{
    int first = 0;
    int count = 0;
};

/// Returns the transducers of each board of \a array, board by board.
std::vector<BoardRange> boardsOf(const TransducerArray& array);

/// Returns the mean position of a board's transducers, metres.
Eigen::Vector3d middleOf(const TransducerArray& array, const BoardRange& board);

/// Moves a board as a whole. \a motion, in the array frame, maps present to new positions.
void moveBoard(const Eigen::Isometry3d& motion, const BoardRange& board, TransducerArray& array);

} // namespace midair::haptics
