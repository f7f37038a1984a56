#include "haptics/boards/BoardMirrors.h"

#include "haptics/base/SmallMatrices.h"
#include "haptics/base/Units.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include <cmath>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

constexpr double kApart_m = 5e-3; // mirror images that are nearer to each other are one
constexpr double kAsLikely = 2.0; // more of the cost: two standard deviations

double costOf(const BoardSolver& solver,
              const std::vector<char>& used,
              double sigma_m,
              const BoardState& state)
{
    const Eigen::VectorXd r = solver.residuals_m(state) / sigma_m;
    double sum = 0.0;
    for (Eigen::Index k = 0; k < r.size(); ++k)
        if (used[static_cast<std::size_t>(k)]) sum += 0.5 * r[k] * r[k];
    return sum;
}

/// Moves \a board so that its measured transducers are where a mirror at the plane of what they are
/// measured to shows them. Returns false if that is no plane.
bool reflect(int board,
             const BoardSolver& solver,
             const BoardMeasurements& measurements,
             const std::vector<char>& used,
             BoardState& state)
{
    const std::vector<int> of = measurementsOf(board, solver, measurements, used);
    Eigen::Matrix3Xd own(3, static_cast<Eigen::Index>(of.size()));
    Eigen::Matrix3Xd others = own;
    for (std::size_t k = 0; k < of.size(); ++k)
    {
        const BoardMeasurement& one = measurements.all[static_cast<std::size_t>(of[k])];
        const bool isFrom = solver.boardOf(one.from) == board;
        const auto column = static_cast<Eigen::Index>(k);
        own.col(column) = solver.at(isFrom ? one.from : one.to, state);
        others.col(column) = solver.at(isFrom ? one.to : one.from, state);
    }
    Eigen::Vector3d normal;
    if (of.size() < 3 || flatness(others, normal)[0] > kFlat_m) return false;
    const Eigen::Vector3d middle = others.rowwise().mean();
    Eigen::Matrix3Xd image = own;
    image -= 2.0 * normal * (normal.transpose() * (own.colwise() - middle));
    const Eigen::Isometry3d motion(base::nearestMotion(own, image, false));
    Eigen::Isometry3d& moved = state.motion[static_cast<std::size_t>(board)];
    moved = motion * moved;
    return true;
}

} // namespace

Eigen::Vector2d flatness(const Eigen::Matrix3Xd& places, Eigen::Vector3d& normal)
{
    const Eigen::Vector3d middle = places.rowwise().mean();
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(places.colwise() - middle, Eigen::ComputeFullU);
    normal = svd.matrixU().col(2);
    Eigen::Vector3d sizes = Eigen::Vector3d::Zero();
    sizes.head(svd.singularValues().size()) = svd.singularValues();
    return Eigen::Vector2d(sizes[2], sizes[1]) / std::sqrt(static_cast<double>(places.cols()));
}

std::vector<int> measurementsOf(int board,
                                const BoardSolver& solver,
                                const BoardMeasurements& measurements,
                                const std::vector<char>& used)
{
    std::vector<int> found;
    for (std::size_t k = 0; k < measurements.all.size(); ++k)
    {
        const BoardMeasurement& one = measurements.all[k];
        if (used[k] && (solver.boardOf(one.from) == board || solver.boardOf(one.to) == board))
            found.push_back(static_cast<int>(k));
    }
    return found;
}

std::vector<std::string> mirrorNotes(const BoardSolver& solver,
                                     const BoardMeasurements& measurements,
                                     const std::vector<char>& used,
                                     double sigma_m,
                                     const BoardState& state)
{
    std::vector<std::string> notes;
    const double cost = costOf(solver, used, sigma_m, state);
    for (int b = 0; b < solver.boards(); ++b)
    {
        BoardState other = state;
        if (!reflect(b, solver, measurements, used, other)) continue;
        solver.fit(used, sigma_m, b, other);
        const auto at = static_cast<std::size_t>(b);
        const double apart_m = (solver.middleOf(b, other) - solver.middleOf(b, state)).norm();
        const double turn =
            Eigen::AngleAxisd(other.motion[at].linear() * state.motion[at].linear().transpose())
                .angle();
        if (std::hypot(apart_m, BoardSolver::kArm_m * turn) < kApart_m ||
            costOf(solver, used, sigma_m, other) > cost + kAsLikely)
            continue;
        notes.push_back(fmt::format(
            "board {} is measured to points in one plane: it could as well be {:.0f} mm away, "
            "turned by {:.0f} degrees, mirrored at that plane; taken is what is nearer to the "
            "array; measure it to a point off that plane",
            b,
            1e3 * apart_m,
            base::toDegrees(turn)));
    }
    return notes;
}

} // namespace midair::haptics
