#include "haptics/surface/SurfacePaint.h"

#include "haptics/surface/TriangleMesh.h"

#include <cmath>

namespace midair::haptics
{

namespace
{

/// Returns the texel for index \a i of the infinite plane, for a side of \a size texels.
int wrapped(double i, int size, PaintImage::Wrap wrap)
{
    const double n = size;
    switch (wrap)
    {
    case PaintImage::Wrap::REPEAT:
        i -= n * std::floor(i / n);
        break;
    case PaintImage::Wrap::MIRROR:
        i -= 2.0 * n * std::floor(i / (2.0 * n));
        if (i >= n) i = 2.0 * n - 1.0 - i;
        break;
    case PaintImage::Wrap::CLAMP:
        break;
    }
    return static_cast<int>(std::fmin(std::fmax(i, 0.0), n - 1.0));
}

} // namespace

float PaintImage::at(double u, double v) const
{
    if (width <= 0 || height <= 0 || !std::isfinite(u) || !std::isfinite(v)) return 1.0f;
    // The centre of texel i is at (i + 1/2)/size.
    const double x = u * width - 0.5;
    const double y = v * height - 0.5;
    const double x0 = std::floor(x);
    const double y0 = std::floor(y);
    double sum = 0.0;
    for (int k = 0; k < 4; ++k)
    {
        const double dx = k & 1;
        const double dy = k >> 1;
        const int column = wrapped(x0 + dx, width, wrapU);
        const int row = wrapped(y0 + dy, height, wrapV);
        const auto index = static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                           static_cast<std::size_t>(column);
        sum += (1.0 - std::abs(x - x0 - dx)) * (1.0 - std::abs(y - y0 - dy)) *
               static_cast<double>(values[index]);
    }
    return static_cast<float>(sum);
}

float intensityAt(const TriangleMesh& mesh, int triangle, const Eigen::Vector3d& barycentric)
{
    const Eigen::Vector3i corners = mesh.triangles.col(triangle);
    if (mesh.paint)
    {
        const int image = mesh.paint->image[static_cast<std::size_t>(triangle)];
        if (image < 0) return 1.0f;
        Eigen::Vector2d uv = Eigen::Vector2d::Zero();
        for (int k = 0; k < 3; ++k)
            uv += barycentric[k] * mesh.paint->coordinates.col(corners[k]);
        return mesh.paint->images[static_cast<std::size_t>(image)]->at(uv[0], uv[1]);
    }
    if (mesh.intensity.size() == 0) return 1.0f;
    double sum = 0.0;
    for (int k = 0; k < 3; ++k)
        sum += barycentric[k] * static_cast<double>(mesh.intensity[corners[k]]);
    return static_cast<float>(sum);
}

} // namespace midair::haptics
