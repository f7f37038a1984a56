#pragma once

#include "haptics/TransducerArray.h"

#include <Eigen/Core>

#include <utility>
#include <vector>

namespace midair::haptics
{

/// A flat board with its transducers on a rectangular grid, all facing the same way: how arrays are put together.
/// Columns run along \a columnsAlong, rows along normal x columnsAlong; both count from 1.
struct BoardGrid
{
    Eigen::Vector3d position = Eigen::Vector3d::Zero();      ///< metres: middle of the whole grid
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();       ///< unit length: direction of emission
    Eigen::Vector3d columnsAlong = Eigen::Vector3d::UnitX(); ///< unit length, across the normal
    int columns = 0;                                         ///< >= 1
    int rows = 0;                                            ///< >= 1
    double pitch_m = 0.0;                                    ///< > 0
    std::vector<std::pair<int, int>> without; ///< (column, row) of places that have no transducer
};

/// A direction for columns that suits \a normal (unit length): level, so that rows run up along +y as far as they can;
/// +x for a board that faces along y.
Eigen::Vector3d levelColumns(const Eigen::Vector3d& normal);

/// Appends the transducers of \a grid to \a array, column by column within row by row, as one more board.
void appendBoard(const BoardGrid& grid, TransducerArray& array);

} // namespace midair::haptics
