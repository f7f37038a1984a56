#include "haptics/array/BoardMotion.h"

namespace midair::haptics
{

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
