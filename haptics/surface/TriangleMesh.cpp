#include "haptics/surface/TriangleMesh.h"

#include "haptics/base/InputError.h"

#include <cmath>

#include <fmt/format.h>

namespace midair::haptics
{

Eigen::Vector3d TriangleMesh::extent() const
{
    if (vertices.cols() == 0) return Eigen::Vector3d::Zero();
    return vertices.rowwise().maxCoeff() - vertices.rowwise().minCoeff();
}

TriangleMesh TriangleMesh::scaledTo(double size_m) const
{
    if (!(size_m > 0.0) || !std::isfinite(size_m))
    {
        throw base::InputError(fmt::format(
            "The size to scale a mesh to is {:g} m; it must be positive and finite", size_m));
    }
    if (vertices.cols() == 0) throw base::InputError("A mesh without vertices can't be scaled");
    for (Eigen::Index i = 0; i < vertices.cols(); ++i)
    {
        if (!vertices.col(i).allFinite())
        {
            throw base::InputError(
                fmt::format("Vertex {} of the mesh is not finite; the mesh can't be scaled", i));
        }
    }
    const Eigen::Vector3d low = vertices.rowwise().minCoeff();
    const Eigen::Vector3d high = vertices.rowwise().maxCoeff();
    // Halves both before subtracting, because the difference of two finite numbers may overflow.
    const double halfExtent = (0.5 * high - 0.5 * low).maxCoeff();
    const double scale = 0.5 * size_m / halfExtent;
    if (!(halfExtent > 0.0) || !std::isfinite(scale))
    {
        throw base::InputError("All vertices of the mesh lie in one point; it can't be scaled");
    }
    TriangleMesh scaled = *this;
    scaled.vertices = scale * (vertices.colwise() - (0.5 * low + 0.5 * high));
    return scaled;
}

} // namespace midair::haptics
