#include "engine-bridge/tags/TagDetector.h"

#include <algorithm>

extern "C"
{
#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
}

namespace midair::bridge
{

struct TagDetector::Library
{
    apriltag_family_t* family = tag36h11_create();
    apriltag_detector_t* detector = apriltag_detector_create();

    Library()
    {
        // At most one wrong bit: few false detections.
        apriltag_detector_add_family_bits(detector, family, 1);
        detector->quad_decimate = 1.0F; // full resolution, for the most accurate corners
        detector->nthreads = 1;
    }
    ~Library()
    {
        apriltag_detector_destroy(detector);
        tag36h11_destroy(family);
    }
    Library(const Library&) = delete;
    Library& operator=(const Library&) = delete;
};

TagDetector::TagDetector() : _library(std::make_unique<Library>()) {}

TagDetector::~TagDetector() = default;

std::vector<TagSeen> TagDetector::detect(const GrayImage& image)
{
    GrayImage copy = image; // the library may modify it
    image_u8_t view = {image.width, image.height, image.width, copy.pixels.data()};
    zarray_t* const found = apriltag_detector_detect(_library->detector, &view);
    std::vector<TagSeen> tags;
    std::vector<int> twice;
    for (int i = 0; i < zarray_size(found); ++i)
    {
        apriltag_detection_t* one = nullptr;
        zarray_get(found, i, &one);
        TagSeen tag;
        tag.id = one->id;
        for (std::size_t k = 0; k < 4; ++k)
            tag.corners[k] = {one->p[k][0], one->p[k][1]};
        const auto same = [&](const TagSeen& other) { return other.id == tag.id; };
        if (std::any_of(tags.begin(), tags.end(), same)) twice.push_back(tag.id);
        tags.push_back(tag);
    }
    apriltag_detections_destroy(found);
    tags.erase(std::remove_if(tags.begin(),
                              tags.end(),
                              [&](const TagSeen& tag)
                              { return std::count(twice.begin(), twice.end(), tag.id) > 0; }),
               tags.end());
    return tags;
}

GrayImage TagDetector::bitmap(int id) const
{
    const apriltag_family_t& family = *_library->family;
    GrayImage image{kBitmap, kBitmap, {}};
    image.pixels.assign(static_cast<std::size_t>(kBitmap) * kBitmap, 0);
    for (int i = 0; i < kBitmap; ++i)
        image.at(i, 0) = image.at(i, kBitmap - 1) = image.at(0, i) = image.at(kBitmap - 1, i) = 255;
    constexpr int kBegin = (kBitmap - kSquares) / 2;
    for (std::uint32_t bit = 0; bit < family.nbits; ++bit)
        if ((family.codes[id] >> (family.nbits - 1 - bit) & 1U) != 0)
            image.at(kBegin + static_cast<int>(family.bit_x[bit]),
                     kBegin + static_cast<int>(family.bit_y[bit])) = 255;
    return image;
}

} // namespace midair::bridge
