#include "haptics/propagation/FreeLines.h"

#include <Eigen/Geometry>

#include <cmath>

namespace midair::haptics
{

namespace
{

constexpr double kFlat_m = 1e-3; // transducers that are off the plane by less are in it
constexpr Eigen::Index kFewest = 4;
constexpr double kTouching_m = 1e-6;

} // namespace

FreeLines::FreeLines(const TransducerArray& array) : _positions(array.positions)
{
    const Eigen::Index m = array.positions.cols();
    _own.assign(static_cast<std::size_t>(m), -1);
    const bool isNumbered = static_cast<Eigen::Index>(array.board.size()) == m;
    for (Eigen::Index first = 0; first < m;)
    {
        Eigen::Index last = first + 1;
        while (last < m && (!isNumbered || array.board[static_cast<std::size_t>(last)] ==
                                               array.board[static_cast<std::size_t>(first)]))
            ++last;
        addBoard(array, first, last);
        first = last;
    }
}

void FreeLines::addBoard(const TransducerArray& array, Eigen::Index first, Eigen::Index last)
{
    if (last - first < kFewest) return;
    Rectangle board;
    board.corner = array.positions.col(first);
    board.normal = array.normals.col(first);
    const Eigen::Matrix3Xd d =
        array.positions.middleCols(first, last - first).colwise() - board.corner;
    if ((board.normal.transpose() * d).cwiseAbs().maxCoeff() > kFlat_m) return;
    Eigen::Index nearest = 0;
    const double pitch_m =
        std::sqrt(d.rightCols(d.cols() - 1).colwise().squaredNorm().minCoeff(&nearest));
    if (!(pitch_m > 0.0)) return;
    // Along the rows, so that the rectangle is as small as the board.
    Eigen::Vector3d along = d.col(nearest + 1);
    along -= board.normal * board.normal.dot(along);
    board.u = along.normalized();
    board.v = board.normal.cross(board.u);
    const Eigen::RowVectorXd a = board.u.transpose() * d;
    const Eigen::RowVectorXd b = board.v.transpose() * d;
    board.low = Eigen::Vector2d(a.minCoeff(), b.minCoeff()).array() - 0.5 * pitch_m;
    board.high = Eigen::Vector2d(a.maxCoeff(), b.maxCoeff()).array() + 0.5 * pitch_m;
    for (Eigen::Index i = first; i < last; ++i)
        _own[static_cast<std::size_t>(i)] = static_cast<int>(_boards.size());
    _boards.push_back(board);
}

bool FreeLines::isFree(Eigen::Index i, const Eigen::Vector3d& place) const
{
    const Eigen::Vector3d from = _positions.col(i);
    const int own = _own[static_cast<std::size_t>(i)];
    for (int b = 0; b < static_cast<int>(_boards.size()); ++b)
    {
        const Rectangle& board = _boards[static_cast<std::size_t>(b)];
        const double end_m = board.normal.dot(place - board.corner);
        if (b == own)
        {
            if (end_m <= 0.0) return false;
            continue;
        }
        const double start_m = board.normal.dot(from - board.corner);
        if (std::abs(start_m) < kTouching_m || start_m * end_m >= 0.0) continue;
        const double share = start_m / (start_m - end_m);
        const Eigen::Vector3d hit = from + share * (place - from) - board.corner;
        const Eigen::Vector2d at(board.u.dot(hit), board.v.dot(hit));
        if ((at.array() >= board.low.array()).all() && (at.array() <= board.high.array()).all())
            return false;
    }
    return true;
}

} // namespace midair::haptics
