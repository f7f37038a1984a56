#pragma once

#include <Eigen/Core>

#include <memory>
#include <vector>

namespace midair::haptics
{

struct TriangleMesh;

/// A picture of how strongly a surface is felt: intensities, 0 .. 1, over the unit square of
/// texture coordinates.
struct PaintImage
{
    /// What is felt beyond the picture's edges.
    enum class Wrap
    {
        CLAMP, ///< its border
        REPEAT,
        MIRROR
    };

    int width = 0;
    int height = 0;
    std::vector<float> values; ///< width x height, row by row, that of v = 0 first
    Wrap wrapU = Wrap::REPEAT;
    Wrap wrapV = Wrap::REPEAT;

    /// Bilinear between the middles of the four nearest texels; 1 where the picture is empty or (\a
    /// u, \a v) not finite.
    float at(double u, double v) const;
};

/// Pictures laid over a mesh by texture coordinates.
struct SurfacePaint
{
    Eigen::Matrix2Xd coordinates; ///< 2 x v
    std::vector<std::shared_ptr<const PaintImage>> images;
    std::vector<int> image; ///< t: which of images; -1: none, felt in full
};

/// How strongly the surface is felt at a place, 0 .. 1: as its paint says, else by the intensities
/// of its corners, else 1.
float intensityAt(const TriangleMesh& mesh, int triangle, const Eigen::Vector3d& barycentric);

} // namespace midair::haptics
