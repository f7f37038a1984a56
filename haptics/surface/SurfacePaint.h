#pragma once

#include <Eigen/Core>

#include <memory>
#include <vector>

namespace midair::haptics
{

struct TriangleMesh;

/// Image of haptic intensity: 0 .. 1, over the unit square of texture coordinates.
struct PaintImage
{
    /// Continuation of the image beyond its edges.
    enum class Wrap
    {
        CLAMP, ///< nearest texel of the border
        REPEAT,
        MIRROR
    };

    int width = 0;
    int height = 0;
    std::vector<float> values; ///< width x height, row by row, starting with v = 0
    Wrap wrapU = Wrap::REPEAT;
    Wrap wrapV = Wrap::REPEAT;

    /// Returns the intensity, interpolated bilinearly between the centres of the four nearest
    /// texels; 1 if the image is empty or (\a u, \a v) not finite.
    float at(double u, double v) const;
};

/// Images mapped to a mesh by texture coordinates.
struct SurfacePaint
{
    Eigen::Matrix2Xd coordinates; ///< 2 x v
    std::vector<std::shared_ptr<const PaintImage>> images;
    std::vector<int> image; ///< t: index into images; -1: none, full intensity
};

/// Returns the intensity of the surface at a place, 0 .. 1: that of its paint, otherwise that of
/// its vertices, otherwise 1.
float intensityAt(const TriangleMesh& mesh, int triangle, const Eigen::Vector3d& barycentric);

} // namespace midair::haptics
