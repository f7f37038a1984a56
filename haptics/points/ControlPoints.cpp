#include "haptics/points/ControlPoints.h"

#include <utility>

namespace midair::haptics
{

namespace
{

// Appends \a more to \a to if both are complete, otherwise empties it.
template<typename T>
void appendIfComplete(std::vector<T>& to, std::size_t n, const std::vector<T>& more, std::size_t m)
{
    if (to.size() == n && more.size() == m)
        to.insert(to.end(), more.begin(), more.end());
    else
        to.clear();
}

/// Appends \a more (m rows) to \a to (n rows); a side without rows gets zeros. Rows of different
/// lengths belong to different arrays: \a to then keeps a wrong number of rows, which solvers
/// refuse.
void appendRows(std::shared_ptr<const Eigen::MatrixXcf>& to,
                Eigen::Index n,
                const std::shared_ptr<const Eigen::MatrixXcf>& more,
                Eigen::Index m)
{
    if ((!to && !more) || (to && more && to->cols() != more->cols())) return;
    Eigen::MatrixXcf both = Eigen::MatrixXcf::Zero(n + m, to ? to->cols() : more->cols());
    if (to && to->rows() == n) both.topRows(n) = *to;
    if (more && more->rows() == m) both.bottomRows(m) = *more;
    to = std::make_shared<const Eigen::MatrixXcf>(std::move(both));
}

} // namespace

ControlPoints pick(const ControlPoints& points, const std::vector<int>& chosen)
{
    const auto n = static_cast<Eigen::Index>(chosen.size());
    ControlPoints result;
    result.absolute = points.absolute;
    result.positions.resize(3, n);
    result.normals.resize(3, points.normals.cols() > 0 ? n : 0);
    result.targets.resize(n);
    result.outside_Pa.resize(points.outside_Pa.size() > 0 ? n : 0);
    if (points.outsideRows_Pa)
        result.outsideRows_Pa =
            std::make_shared<const Eigen::MatrixXcf>((*points.outsideRows_Pa)(chosen, Eigen::all));
    for (Eigen::Index l = 0; l < n; ++l)
    {
        const int from = chosen[static_cast<std::size_t>(l)];
        const auto index = static_cast<std::size_t>(from);
        result.positions.col(l) = points.positions.col(from);
        if (points.normals.cols() > 0) result.normals.col(l) = points.normals.col(from);
        result.targets[l] = points.targets[from];
        if (points.outside_Pa.size() > 0) result.outside_Pa[l] = points.outside_Pa[from];
        if (!points.object.empty()) result.object.push_back(points.object[index]);
        if (!points.identity.empty()) result.identity.push_back(points.identity[index]);
    }
    return result;
}

void append(ControlPoints& to, const ControlPoints& more)
{
    if (to.size() == 0) to.absolute = more.absolute;
    const Eigen::Index n = to.positions.cols(), m = more.positions.cols();
    to.positions.conservativeResize(3, n + m);
    to.positions.rightCols(m) = more.positions;
    const Eigen::Index known = to.normals.cols();
    to.normals.conservativeResize(3, n + m);
    // Curves and tests have no normals: zeros instead of uninitialised memory.
    if (known != n) to.normals.leftCols(n).setZero();
    if (more.normals.cols() == m)
        to.normals.rightCols(m) = more.normals;
    else
        to.normals.rightCols(m).setZero();
    to.targets.conservativeResize(n + m);
    to.targets.tail(m) = more.targets;
    if (to.outside_Pa.size() > 0 || more.outside_Pa.size() > 0)
    {
        Eigen::VectorXcd outside_Pa = Eigen::VectorXcd::Zero(n + m);
        if (to.outside_Pa.size() == n) outside_Pa.head(n) = to.outside_Pa;
        if (more.outside_Pa.size() == m) outside_Pa.tail(m) = more.outside_Pa;
        to.outside_Pa = std::move(outside_Pa);
    }
    appendRows(to.outsideRows_Pa, n, more.outsideRows_Pa, m);
    const auto first = static_cast<std::size_t>(n), second = static_cast<std::size_t>(m);
    appendIfComplete(to.object, first, more.object, second);
    appendIfComplete(to.identity, first, more.identity, second);
}

ControlPoints feltPlaces(const Eigen::Matrix3Xd& samples,
                         const ControlPoints& points,
                         double reach_m,
                         const base::StopToken& stop)
{
    ControlPoints places;
    places.absolute = points.absolute;
    places.positions.resize(3, samples.cols());
    places.targets.resize(samples.cols());
    Eigen::Index count = 0;
    base::StopLook look(stop);
    for (const auto& sample : samples.colwise())
    {
        look.turn();
        if (points.size() == 0) continue;
        Eigen::Index nearest = 0;
        const double distance2 =
            (points.positions.colwise() - sample).colwise().squaredNorm().minCoeff(&nearest);
        if (!(distance2 <= reach_m * reach_m)) continue;
        places.positions.col(count) = sample;
        places.targets[count++] = points.targets[nearest];
    }
    places.positions.conservativeResize(3, count);
    places.targets.conservativeResize(count);
    places.normals = Eigen::Matrix3Xd::Zero(3, count);
    return places;
}

} // namespace midair::haptics
