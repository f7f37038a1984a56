#include "haptics/BoardGrid.h"

#include <Eigen/Geometry>

#include <algorithm>

namespace midair::haptics
{

Eigen::Vector3d levelColumns(const Eigen::Vector3d& normal)
{
    const Eigen::Vector3d across = Eigen::Vector3d::UnitY().cross(normal);
    const double length = across.norm();
    return length > 1e-6 ? Eigen::Vector3d(across / length) : Eigen::Vector3d::UnitX();
}

void appendBoard(const BoardGrid& grid, TransducerArray& array)
{
    const Eigen::Vector3d rowsAlong = grid.normal.cross(grid.columnsAlong);
    const int board = array.board.empty() ? 0 : array.board.back() + 1;
    std::vector<Eigen::Vector3d> places;
    for (int row = 1; row <= grid.rows; ++row)
        for (int column = 1; column <= grid.columns; ++column)
        {
            const std::pair<int, int> place(column, row);
            if (std::find(grid.without.begin(), grid.without.end(), place) != grid.without.end())
                continue;
            places.emplace_back(grid.position +
                                (column - 0.5 * (grid.columns + 1)) * grid.pitch_m *
                                    grid.columnsAlong +
                                (row - 0.5 * (grid.rows + 1)) * grid.pitch_m * rowsAlong);
        }

    const Eigen::Index before = array.positions.cols();
    const auto added = static_cast<Eigen::Index>(places.size());
    array.positions.conservativeResize(Eigen::NoChange, before + added);
    array.normals.conservativeResize(Eigen::NoChange, before + added);
    for (Eigen::Index i = 0; i < added; ++i)
    {
        array.positions.col(before + i) = places[static_cast<std::size_t>(i)];
        array.normals.col(before + i) = grid.normal;
    }
    array.board.resize(static_cast<std::size_t>(before + added), board);
}

} // namespace midair::haptics
