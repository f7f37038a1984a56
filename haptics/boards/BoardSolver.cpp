#include "haptics/boards/BoardSolver.h"

#include "haptics/base/SmallMatrices.h"
#include "haptics/base/Units.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

constexpr int kMostSteps = 200;
constexpr double kEnough_m = 1e-9; // a shorter step ends the fit
constexpr double kHuber = 1.5;     // sigmas

constexpr double kApart_m = 5e-3; // closer mirror images count as one
constexpr double kAsLikely = 2.0; // more of the cost: two standard deviations

} // namespace

BoardSolver::BoardSolver(const TransducerArray& array,
                         const BoardMeasurements& measurements,
                         double soundSpeed_m_s) :
    _array(array),
    _measurements(measurements),
    _soundSpeed_m_s(soundSpeed_m_s),
    _boards(boardsOf(array))
{
    for (std::size_t b = 0; b < _boards.size(); ++b)
        _boardOf.insert(
            _boardOf.end(), static_cast<std::size_t>(_boards[b].count), static_cast<int>(b));
    _parameters = 6 * boards();
    for (const MeasuredPlace& place : measurements.places)
    {
        _parameterOfPlace.push_back(place.isKnown ? -1 : _parameters);
        _parameters += place.isKnown ? 0 : 3;
    }
    const bool hasTimes = std::any_of(measurements.all.begin(),
                                      measurements.all.end(),
                                      [](const BoardMeasurement& one) { return one.isTime; });
    if (hasTimes) _parameterOfDelay = _parameters++;
}

BoardState BoardSolver::start() const
{
    BoardState state;
    state.motion.assign(_boards.size(), Eigen::Isometry3d::Identity());
    for (const MeasuredPlace& place : _measurements.places)
        state.places.push_back(place.position);
    return state;
}

int BoardSolver::boardOf(const MeasuredEnd& end) const
{
    return end.transducer < 0 ? -1 : _boardOf[static_cast<std::size_t>(end.transducer)];
}

Eigen::Vector3d BoardSolver::at(const MeasuredEnd& end, const BoardState& state) const
{
    if (end.place >= 0) return state.places[static_cast<std::size_t>(end.place)];
    const Eigen::Vector3d place = _array.positions.col(end.transducer);
    return state.motion[static_cast<std::size_t>(boardOf(end))] * place;
}

Eigen::Vector3d BoardSolver::middleOf(int board, const BoardState& state) const
{
    const auto b = static_cast<std::size_t>(board);
    return state.motion[b] * haptics::middleOf(_array, _boards[b]);
}

Eigen::VectorXd BoardSolver::residuals_m(const BoardState& state) const
{
    Eigen::VectorXd r(static_cast<Eigen::Index>(_measurements.all.size()));
    for (Eigen::Index k = 0; k < r.size(); ++k)
    {
        const BoardMeasurement& one = _measurements.all[static_cast<std::size_t>(k)];
        const double distance_m = (at(one.from, state) - at(one.to, state)).norm();
        r[k] = one.isTime ? distance_m + state.delay_m - _soundSpeed_m_s * one.time_s
                          : distance_m - one.distance_m;
    }
    return r;
}

// d|x - y| = u.(dx - dy) with u = (x - y)/|x - y|; a turn w about the middle c moves x by
// w x (x - c), so that its part is w.((x - c) x u).
void BoardSolver::addEnd(const MeasuredEnd& end,
                         const Eigen::Vector3d& along,
                         const BoardState& state,
                         Eigen::Ref<Eigen::RowVectorXd> row) const
{
    if (end.place >= 0)
    {
        const int first = _parameterOfPlace[static_cast<std::size_t>(end.place)];
        if (first >= 0) row.segment<3>(first) += along.transpose();
        return;
    }
    const int board = boardOf(end);
    const Eigen::Vector3d arm = at(end, state) - middleOf(board, state);
    row.segment<3>(parameterOf(board)) += along.transpose();
    row.segment<3>(parameterOf(board) + 3) += arm.cross(along).transpose() / kArm_m;
}

Eigen::MatrixXd BoardSolver::jacobian(const BoardState& state) const
{
    Eigen::MatrixXd J =
        Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(_measurements.all.size()), _parameters);
    Eigen::RowVectorXd row(_parameters);
    for (Eigen::Index k = 0; k < J.rows(); ++k)
    {
        const BoardMeasurement& one = _measurements.all[static_cast<std::size_t>(k)];
        const Eigen::Vector3d along = (at(one.from, state) - at(one.to, state)).stableNormalized();
        row.setZero();
        addEnd(one.from, along, state, row);
        addEnd(one.to, -along, state, row);
        if (one.isTime) row[_parameterOfDelay] += 1.0;
        J.row(k) = row;
    }
    return J;
}

Eigen::MatrixXd BoardSolver::rigidMotions(const BoardState& state) const
{
    Eigen::MatrixXd moves = Eigen::MatrixXd::Zero(_parameters, 6);
    const auto setPlace = [&](int first, const Eigen::Vector3d& place)
    {
        moves.block<3, 3>(first, 0).setIdentity();
        for (int axis = 0; axis < 3; ++axis)
            moves.block<3, 1>(first, 3 + axis) = Eigen::Vector3d::Unit(axis).cross(place);
    };
    for (int b = 0; b < boards(); ++b)
    {
        setPlace(parameterOf(b), middleOf(b, state));
        moves.block<3, 3>(parameterOf(b) + 3, 3) = kArm_m * Eigen::Matrix3d::Identity();
    }
    for (std::size_t p = 0; p < _parameterOfPlace.size(); ++p)
        if (_parameterOfPlace[p] >= 0) setPlace(_parameterOfPlace[p], state.places[p]);
    return Eigen::HouseholderQR<Eigen::MatrixXd>(moves).householderQ() *
           Eigen::MatrixXd::Identity(_parameters, 6);
}

void BoardSolver::step(const Eigen::VectorXd& by, BoardState& state) const
{
    for (int b = 0; b < boards(); ++b)
    {
        const Eigen::Vector3d middle = middleOf(b, state);
        const Eigen::Vector3d shift = by.segment<3>(parameterOf(b));
        const Eigen::Vector3d turn = by.segment<3>(parameterOf(b) + 3) / kArm_m;
        Eigen::Isometry3d& motion = state.motion[static_cast<std::size_t>(b)];
        motion = Eigen::Translation3d(middle + shift) *
                 Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()) *
                 Eigen::Translation3d(-middle) * motion;
        // Rounding accumulates over many products.
        motion.linear() = Eigen::Quaterniond(motion.linear()).normalized().toRotationMatrix();
    }
    for (std::size_t p = 0; p < state.places.size(); ++p)
        if (_parameterOfPlace[p] >= 0) state.places[p] += by.segment<3>(_parameterOfPlace[p]);
    if (_parameterOfDelay >= 0) state.delay_m += by[_parameterOfDelay];
}

void BoardSolver::fit(const std::vector<char>& used,
                      double sigma_m,
                      int freeBoard,
                      BoardState& state) const
{
    // Huber's cost: linear for large residuals in sigmas.
    const auto costOf = [&](const BoardState& of)
    {
        const Eigen::ArrayXd size = sigmasOf(used, sigma_m, of).abs();
        return (size <= kHuber).select(0.5 * size.square(), kHuber * (size - 0.5 * kHuber)).sum();
    };
    double cost = costOf(state), damping = 1e-3;
    for (int tried = 0; tried < kMostSteps && damping < 1e12; ++tried)
    {
        const Eigen::ArrayXd r = sigmasOf(used, sigma_m, state);
        Eigen::MatrixXd J = jacobian(state) / sigma_m;
        if (freeBoard >= 0)
        {
            J.leftCols(parameterOf(freeBoard)).setZero();
            J.rightCols(_parameters - parameterOf(freeBoard) - 6).setZero();
        }
        for (Eigen::Index k = 0; k < r.size(); ++k)
            if (!used[static_cast<std::size_t>(k)]) J.row(k).setZero();
        const Eigen::VectorXd w = kHuber / r.abs().max(kHuber);
        const Eigen::VectorXd slope = J.transpose() * (w.array() * r).matrix();
        Eigen::MatrixXd H = J.transpose() * w.asDiagonal() * J;
        // Equal damping in metres, so that undetermined parameters stay where they are.
        H.diagonal().array() += damping / (sigma_m * sigma_m);
        const Eigen::VectorXd by = -H.ldlt().solve(slope);
        BoardState next = state;
        step(by, next);
        const double nextCost = costOf(next);
        if (!(nextCost <= cost))
        {
            damping *= 10.0;
            continue;
        }
        state = next;
        cost = nextCost;
        damping = std::max(damping / 10.0, 1e-9);
        if (by.cwiseAbs().maxCoeff() < kEnough_m) break;
    }
}

Eigen::Vector2d flatness(const Eigen::Matrix3Xd& places, Eigen::Vector3d& normal)
{
    const Eigen::Vector3d middle = places.rowwise().mean();
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(places.colwise() - middle, Eigen::ComputeFullU);
    normal = svd.matrixU().col(2);
    Eigen::Vector3d sizes = Eigen::Vector3d::Zero();
    sizes.head(svd.singularValues().size()) = svd.singularValues();
    return Eigen::Vector2d(sizes[2], sizes[1]) / std::sqrt(static_cast<double>(places.cols()));
}

std::vector<BoardMeasurement> BoardSolver::measurementsOf(int board,
                                                          const std::vector<char>& used) const
{
    std::vector<BoardMeasurement> found;
    for (std::size_t k = 0; k < used.size(); ++k)
    {
        const BoardMeasurement& one = _measurements.all[k];
        if (used[k] && (boardOf(one.from) == board || boardOf(one.to) == board))
            found.push_back(one);
    }
    return found;
}

/// Residuals of those in \a used, in sigmas; 0: not used.
Eigen::ArrayXd
BoardSolver::sigmasOf(const std::vector<char>& used, double sigma_m, const BoardState& state) const
{
    const Eigen::Map<const Eigen::Array<char, Eigen::Dynamic, 1>> isUsed(
        used.data(), static_cast<Eigen::Index>(used.size()));
    return (isUsed != 0).select(residuals_m(state).array() / sigma_m, 0.0);
}

/// Moves \a board to its mirror image at the plane of the points that it is measured to. Returns
/// false if they don't lie in a plane.
bool BoardSolver::reflect(int board, const std::vector<char>& used, BoardState& state) const
{
    const std::vector<BoardMeasurement> of = measurementsOf(board, used);
    Eigen::Matrix3Xd own(3, static_cast<Eigen::Index>(of.size()));
    Eigen::Matrix3Xd others = own;
    for (Eigen::Index k = 0; k < own.cols(); ++k)
    {
        const BoardMeasurement& one = of[static_cast<std::size_t>(k)];
        const bool isFrom = boardOf(one.from) == board;
        own.col(k) = at(isFrom ? one.from : one.to, state);
        others.col(k) = at(isFrom ? one.to : one.from, state);
    }
    Eigen::Vector3d normal;
    if (of.size() < 3 || flatness(others, normal)[0] > kFlat_m) return false;
    const Eigen::Vector3d middle = others.rowwise().mean();
    Eigen::Matrix3Xd image = own;
    image -= 2.0 * normal * (normal.transpose() * (own.colwise() - middle));
    Eigen::Isometry3d& moved = state.motion[static_cast<std::size_t>(board)];
    moved = Eigen::Isometry3d(base::nearestMotion(own, image, false)) * moved;
    return true;
}

std::vector<std::string> BoardSolver::mirrorNotes(const std::vector<char>& used,
                                                  double sigma_m,
                                                  const BoardState& state) const
{
    std::vector<std::string> notes;
    const auto costOf = [&](const BoardState& of)
    { return 0.5 * sigmasOf(used, sigma_m, of).square().sum(); };
    const double cost = costOf(state);
    for (int b = 0; b < boards(); ++b)
    {
        BoardState other = state;
        if (!reflect(b, used, other)) continue;
        fit(used, sigma_m, b, other);
        const auto index = static_cast<std::size_t>(b);
        const double apart_m = (middleOf(b, other) - middleOf(b, state)).norm();
        const double turn = Eigen::AngleAxisd(other.motion[index].linear() *
                                              state.motion[index].linear().transpose())
                                .angle();
        if (std::hypot(apart_m, kArm_m * turn) < kApart_m || costOf(other) > cost + kAsLikely)
            continue;
        notes.push_back(
            fmt::format("board {} is measured to points in one plane: its mirror image at that "
                        "plane, {:.0f} mm away and turned by {:.0f} degrees, fits as well; the one "
                        "nearer to the array's is used; measure it to a point off that plane",
                        b,
                        1e3 * apart_m,
                        base::toDegrees(turn)));
    }
    return notes;
}

} // namespace midair::haptics
