#pragma once

#include "engine-bridge/tags/GrayImage.h"

#include <Eigen/Core>

#include <array>
#include <memory>
#include <vector>

namespace midair::bridge
{

/// A tag in an image: its number, and the corners of its black square, lower left, lower right,
/// upper right, upper left as printed; pixels from the image's upper left corner, x to the right
/// and y down.
struct TagSeen
{
    int id = 0;
    std::array<Eigen::Vector2d, 4> corners;
};

/// Finds AprilTags of the family tag36h11 in images, by libapriltag. For one thread.
class TagDetector
{
public:
    static constexpr int kTags = 587; ///< of the family, from 0

    /// Throws base::InputError in builds without libapriltag.
    TagDetector();
    ~TagDetector();

    /// Returns each tag once. A tag seen twice is ambiguous and left out.
    std::vector<TagSeen> detect(const GrayImage& image);

    /// Returns the tag \a id as printed, one pixel per square: 10 x 10, with a black border of one
    /// square and a white one around it.
    GrayImage bitmap(int id) const;

    static constexpr int kBitmap = 10; ///< squares of a bitmap's edge
    static constexpr int kSquares = 8; ///< of the black square's edge

private:
    struct Library;
    std::unique_ptr<Library> _library;
};

} // namespace midair::bridge
