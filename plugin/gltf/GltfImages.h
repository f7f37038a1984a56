#pragma once

#include "plugin/gltf/GltfMessages.h"
#include "plugin/gltf/GltfNumbers.h"
#include "plugin/gltf/TinyGltf.h"

#include <osg/Image>
#include <osg/ref_ptr>

#include <cstddef>
#include <string>
#include <vector>

namespace osgMidair
{

/// Decodes a model's PNG and JPEG images, each once, by OSG's plugins for them. One that can't be
/// is left out, and told.
class GltfImages
{
public:
    static constexpr std::size_t kMostPixels = std::size_t(64) << 20; ///< of all together
    static constexpr std::size_t kLongestSide = 16384;

    GltfImages(const tinygltf::Model& model, const GltfNumbers& numbers, GltfMessages& messages);

    /// Image \a number; null if there is none.
    osg::ref_ptr<osg::Image> get(int number);

private:
    osg::ref_ptr<osg::Image> decode(int number);

    const tinygltf::Model& _model;
    const GltfNumbers& _numbers;
    GltfMessages& _messages;
    std::size_t _left = kMostPixels;
    std::vector<bool> _isDecoded;
    std::vector<osg::ref_ptr<osg::Image>> _images;
};

/// Width and height as the header of a PNG or JPEG file says, before anything is decoded: a file of
/// some bytes may say that it has gigabytes.
struct ImageSize
{
    std::size_t width = 0; ///< 0: no PNG nor JPEG
    std::size_t height = 0;
    const char* extension = ""; ///< "png", "jpg"
};
ImageSize imageSizeOf(const unsigned char* bytes, std::size_t size);

} // namespace osgMidair
