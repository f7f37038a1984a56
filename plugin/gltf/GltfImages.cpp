#include "plugin/gltf/GltfImages.h"

#include "plugin/gltf/GltfMessages.h"

#include <osgDB/Registry>

#include <cstring>
#include <sstream>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

std::size_t bigEndian(const unsigned char* bytes, int count)
{
    std::size_t value = 0;
    for (int i = 0; i < count; ++i)
        value = value << 8 | bytes[i];
    return value;
}

/// A JPEG file is a row of segments, of which one begins a frame and has its size.
ImageSize jpegSize(const unsigned char* bytes, std::size_t size)
{
    for (std::size_t at = 2; at + 9 <= size && bytes[at] == 0xFF;)
    {
        const unsigned char marker = bytes[at + 1];
        if (marker == 0xFF) // fills
        {
            ++at;
            continue;
        }
        const bool isFrame =
            marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
        if (isFrame) return {bigEndian(bytes + at + 7, 2), bigEndian(bytes + at + 5, 2), "jpg"};
        at += 2 + bigEndian(bytes + at + 2, 2);
    }
    return {};
}

} // namespace

ImageSize imageSizeOf(const unsigned char* bytes, std::size_t size)
{
    if (size >= 24 && std::memcmp(bytes, "\x89PNG\r\n\x1A\n", 8) == 0 &&
        std::memcmp(bytes + 12, "IHDR", 4) == 0)
        return {bigEndian(bytes + 16, 4), bigEndian(bytes + 20, 4), "png"};
    if (size >= 4 && bytes[0] == 0xFF && bytes[1] == 0xD8) return jpegSize(bytes, size);
    return {};
}

GltfImages::GltfImages(const tinygltf::Model& model,
                       const GltfNumbers& numbers,
                       GltfMessages& messages) :
    _model(model),
    _numbers(numbers),
    _messages(messages),
    _isDecoded(model.images.size()),
    _images(model.images.size())
{
}

osg::ref_ptr<osg::Image> GltfImages::get(int number)
{
    if (number < 0 || static_cast<std::size_t>(number) >= _images.size()) return nullptr;
    const auto at = static_cast<std::size_t>(number);
    if (!_isDecoded[at])
    {
        _isDecoded[at] = true;
        _images[at] = decode(number);
    }
    return _images[at];
}

osg::ref_ptr<osg::Image> GltfImages::decode(int number)
{
    const tinygltf::Image& image = _model.images[static_cast<std::size_t>(number)];
    std::string why;
    try
    {
        std::size_t size = image.image.size();
        const unsigned char* bytes = image.image.data();
        if (image.bufferView >= 0) bytes = _numbers.bytesOf(image.bufferView, size);
        const ImageSize seen = imageSizeOf(bytes, size);
        const bool isSmall = seen.width > 0 && seen.height > 0 && seen.width <= kLongestSide &&
                             seen.height <= kLongestSide && seen.width * seen.height <= _left;
        osgDB::ReaderWriter* reader = nullptr;
        if (size == 0)
            why = "its file can't be read";
        else if (seen.width == 0)
            why = "it is no PNG or JPEG";
        else if (!isSmall)
            why = fmt::format(
                "{} x {} pixels are more than there is room for", seen.width, seen.height);
        else if (reader = osgDB::Registry::instance()->getReaderWriterForExtension(seen.extension);
                 !reader)
            why = std::string("OSG has no plugin for ") + seen.extension;
        if (reader)
        {
            _left -= seen.width * seen.height;
            std::istringstream in(std::string(reinterpret_cast<const char*>(bytes), size));
            osgDB::ReaderWriter::ReadResult result = reader->readImage(in, nullptr);
            osg::ref_ptr<osg::Image> read = result.getImage();
            if (read && read->s() > 0)
            {
                read->setName(image.name);
                return read;
            }
            why = "it can't be decoded";
        }
    }
    catch (const GltfError& error)
    {
        why = error.what();
    }
    _messages.say(fmt::format("image {} \"{}\" is left out: {}", number, image.name, why));
    return nullptr;
}

} // namespace osgMidair
