#include "haptics/array/BoardGrid.h"

#include <Eigen/Geometry>

#include <set>

namespace midair::haptics
{

std::vector<Eigen::Vector2d>
gridPlaces(int columns, int rows, double pitch_m, const std::vector<std::pair<int, int>>& without)
{
    const std::set<std::pair<int, int>> leftOut(without.begin(), without.end());
    std::vector<Eigen::Vector2d> places;
    for (int row = 1; row <= rows; ++row)
        for (int column = 1; column <= columns; ++column)
        {
            if (leftOut.count({column, row}) != 0) continue;
            places.emplace_back((column - 0.5 * (columns + 1)) * pitch_m,
                                (row - 0.5 * (rows + 1)) * pitch_m);
        }
    return places;
}

Eigen::Vector3d levelColumns(const Eigen::Vector3d& normal)
{
    const Eigen::Vector3d across = Eigen::Vector3d::UnitY().cross(normal);
    const double length = across.norm();
    return length > 1e-6 ? Eigen::Vector3d(across / length) : Eigen::Vector3d::UnitX();
}

void appendBoard(const Board& board, TransducerArray& array)
{
    const Eigen::Vector3d rowsAlong = board.normal.cross(board.columnsAlong);
    const int index = array.board.empty() ? 0 : array.board.back() + 1;
    const Eigen::Index before = array.positions.cols();
    const auto added = static_cast<Eigen::Index>(board.places.size());
    array.positions.conservativeResize(Eigen::NoChange, before + added);
    array.normals.conservativeResize(Eigen::NoChange, before + added);
    for (Eigen::Index i = 0; i < added; ++i)
    {
        const Eigen::Vector2d& place = board.places[static_cast<std::size_t>(i)];
        array.positions.col(before + i) =
            board.position + place.x() * board.columnsAlong + place.y() * rowsAlong;
        array.normals.col(before + i) = board.normal;
    }
    array.board.resize(static_cast<std::size_t>(before + added), index);
}

std::vector<BoardRange> boardsOf(const TransducerArray& array)
{
    std::vector<BoardRange> boards;
    for (int i = 0; i < array.size(); ++i)
    {
        const auto index = static_cast<std::size_t>(i);
        if (i == 0 || array.board[index] != array.board[index - 1]) boards.push_back({i, 0});
        ++boards.back().count;
    }
    return boards;
}

Eigen::Vector3d middleOf(const TransducerArray& array, const BoardRange& board)
{
    return array.positions.middleCols(board.first, board.count).rowwise().mean();
}

void moveBoard(const Eigen::Isometry3d& motion, const BoardRange& board, TransducerArray& array)
{
    auto places = array.positions.middleCols(board.first, board.count);
    places = (motion.linear() * places).colwise() + motion.translation();
    auto normals = array.normals.middleCols(board.first, board.count);
    normals = (motion.linear() * normals).eval();
    normals.colwise().normalize();
}

} // namespace midair::haptics
