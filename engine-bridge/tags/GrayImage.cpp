#include "engine-bridge/tags/GrayImage.h"

#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/text/Words.h"

#include <algorithm>
#include <sstream>

namespace midair::bridge
{

namespace
{

constexpr std::size_t kMostImage_bytes = std::size_t(64) << 20U;
constexpr int kMostImage_px = 16384;

} // namespace

GrayImage readPgm(const std::string& path)
{
    const std::string name = "image \"" + base::printable(path) + "\" ";
    const std::string text = base::readRegularFile(path, kMostImage_bytes, name);
    std::istringstream in(text);
    in.imbue(std::locale::classic());
    std::string kind;
    GrayImage image;
    int most = 0;
    in >> kind;
    const auto number = [&](int& value)
    {
        while (in >> std::ws && in.peek() == '#')
            in.ignore(static_cast<std::streamsize>(text.size()), '\n');
        in >> value;
    };
    number(image.width);
    number(image.height);
    number(most);
    in.get();
    const bool isFine = in && kind == "P5" && most == 255 && image.width > 0 && image.height > 0 &&
                        image.width <= kMostImage_px && image.height <= kMostImage_px;
    if (!isFine) throw base::InputError(name + "is no PGM file with 8 bits a pixel (P5, 255)");
    image.pixels.resize(static_cast<std::size_t>(image.width) *
                        static_cast<std::size_t>(image.height));
    in.read(reinterpret_cast<char*>(image.pixels.data()),
            static_cast<std::streamsize>(image.pixels.size()));
    if (!in) throw base::InputError(name + "ends before its last pixel");
    return image;
}

GrayImage mirroredImage(const GrayImage& image)
{
    GrayImage mirrored = image;
    for (int y = 0; y < image.height; ++y)
    {
        const auto row = mirrored.pixels.begin() + static_cast<std::ptrdiff_t>(y) * image.width;
        std::reverse(row, row + image.width);
    }
    return mirrored;
}

} // namespace midair::bridge
