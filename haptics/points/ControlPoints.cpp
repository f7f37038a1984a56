#include "haptics/points/ControlPoints.h"

namespace midair::haptics
{

void append(ControlPoints& to, const ControlPoints& more)
{
    if (to.size() == 0) to.absolute = more.absolute;
    const Eigen::Index n = to.positions.cols(), m = more.positions.cols();
    to.positions.conservativeResize(3, n + m);
    to.positions.rightCols(m) = more.positions;
    const Eigen::Index known = to.normals.cols();
    to.normals.conservativeResize(3, n + m);
    // Curves and tests have no normals: fill with zeros instead of uninitialised memory.
    if (known != n) to.normals.leftCols(n).setZero();
    if (more.normals.cols() == m)
        to.normals.rightCols(m) = more.normals;
    else
        to.normals.rightCols(m).setZero();
    to.targets.conservativeResize(n + m);
    to.targets.tail(m) = more.targets;
    const bool told = to.object.size() == static_cast<std::size_t>(n) &&
                      more.object.size() == static_cast<std::size_t>(m);
    if (told)
        to.object.insert(to.object.end(), more.object.begin(), more.object.end());
    else
        to.object.clear();
}

} // namespace midair::haptics
