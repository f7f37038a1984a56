#include "haptics/array/BoardReflectors.h"

#include "haptics/array/BoardGrid.h"
#include "haptics/base/InputError.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

constexpr double kFlatBoard_m = 1e-3;        // of a board, and of several in one plane
const double kLeastAlike = std::cos(0.0175); // of normals
constexpr double kLonePitch_m = 0.01;        // of a transducer by itself

/// Boards in one plane.
struct BoardPlane
{
    Eigen::Vector3d middle, normal;
    std::vector<int> transducers;
};

void addTo(std::vector<BoardPlane>& planes, const TransducerArray& array, const BoardRange& board)
{
    const Eigen::Vector3d middle = middleOf(array, board), normal = array.normals.col(board.first);
    auto plane =
        std::find_if(planes.begin(),
                     planes.end(),
                     [&](const BoardPlane& one)
                     {
                         return one.normal.dot(normal) >= kLeastAlike &&
                                std::abs(one.normal.dot(middle - one.middle)) <= kFlatBoard_m;
                     });
    if (plane == planes.end()) plane = planes.insert(plane, {middle, normal, {}});
    for (int i = board.first; i < board.first + board.count; ++i)
        plane->transducers.push_back(i);
}

// The rectangle lies along the step from the first transducer to the one nearest to it.
Reflector rectangleAround(const BoardPlane& plane, const TransducerArray& array)
{
    const auto count = static_cast<Eigen::Index>(plane.transducers.size());
    Eigen::Matrix3Xd d(3, count);
    for (Eigen::Index i = 0; i < count; ++i)
        d.col(i) = array.positions.col(plane.transducers[static_cast<std::size_t>(i)]) -
                   array.positions.col(plane.transducers.front());
    Reflector one;
    one.normal = plane.normal;
    one.along = levelColumns(plane.normal);
    double pitch_m = kLonePitch_m;
    if (count > 1)
    {
        Eigen::Index nearest = 0;
        pitch_m = std::sqrt(d.rightCols(count - 1).colwise().squaredNorm().minCoeff(&nearest));
        const Eigen::Vector3d step = d.col(nearest + 1);
        if (pitch_m > 0.0) one.along = (step - plane.normal.dot(step) * plane.normal).normalized();
    }
    one.position = array.positions.col(plane.transducers.front());
    const Eigen::Vector3d sides[] = {one.along, one.across()};
    for (int e = 0; e < 2; ++e)
    {
        const Eigen::RowVectorXd at = sides[e].transpose() * d;
        one.size_m[e] = at.maxCoeff() - at.minCoeff() + pitch_m;
        one.position += 0.5 * (at.maxCoeff() + at.minCoeff()) * sides[e];
    }
    one.position += plane.normal * (plane.normal.transpose() * d).mean();
    return one;
}

} // namespace

std::vector<Reflector> boardReflectors(const TransducerArray& array,
                                       double reflection,
                                       double phase_rad,
                                       double accuracy_mm)
{
    std::vector<BoardPlane> planes;
    for (const BoardRange& board : boardsOf(array))
        addTo(planes, array, board);
    std::vector<Reflector> all;
    for (const BoardPlane& plane : planes)
    {
        Reflector one = rectangleAround(plane, array);
        one.name = fmt::format("board plane {}", all.size());
        one.reflection = reflection;
        one.reflectionPhase_rad = phase_rad;
        one.accuracy_mm = accuracy_mm;
        one.isBoard = true;
        for (const int i : plane.transducers)
            if (std::abs(one.heightOf(array.positions.col(i))) > kFlatBoard_m)
                throw base::InputError(
                    fmt::format("board {} is not flat: transducer {} is {:.2g} "
                                "mm from its plane",
                                array.board[static_cast<std::size_t>(i)],
                                i,
                                1e3 * std::abs(one.heightOf(array.positions.col(i)))));
        all.push_back(one);
    }
    if (all.size() > kMostReflectingBoards)
        throw base::InputError(fmt::format(
            "boards are in {} planes; at most {} can reflect", all.size(), kMostReflectingBoards));
    return all;
}

} // namespace midair::haptics
