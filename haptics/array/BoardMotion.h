#pragma once

#include "haptics/array/TransducerArray.h"

#include <Eigen/Geometry>

#include <vector>

namespace midair::haptics
{

/// Transducers of one board, which follow one another: the first, and how many.
struct BoardRange
{
    int first = 0;
    int count = 0;
};

/// Returns the transducers of each board of \a array, board by board.
std::vector<BoardRange> boardsOf(const TransducerArray& array);

/// Returns the middle of a board, the mean of its transducers' places, metres.
Eigen::Vector3d middleOf(const TransducerArray& array, const BoardRange& board);

/// Moves a board as a whole: \a motion, in the array's frame, takes its transducers from where they
/// are to where they are to be.
void moveBoard(const Eigen::Isometry3d& motion, const BoardRange& board, TransducerArray& array);

} // namespace midair::haptics
