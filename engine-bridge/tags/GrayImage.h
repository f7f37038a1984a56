#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace midair::bridge
{

/// A camera image: rows from the top, one byte per pixel.
struct GrayImage
{
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> pixels;

    std::uint8_t& at(int x, int y)
    {
        return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                      static_cast<std::size_t>(x)];
    }
};

/// Reads a PGM file (P5, 8 bits), to which image tools convert all other formats. Throws
/// base::InputError.
GrayImage readPgm(const std::string& path);
/// Returns \a image mirrored horizontally.
GrayImage mirroredImage(const GrayImage& image);

} // namespace midair::bridge
