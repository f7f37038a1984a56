#include "engine-bridge/tags/VideoCamera.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/Words.h"

#include <cerrno>
#include <cstdint>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace midair::bridge
{

namespace
{

constexpr unsigned int kVideoBuffers = 4;
constexpr int kVideoPatience_ms = 200;

int videoCall(int file, unsigned long request, void* argument)
{
    int status = -1;
    do
        status = ioctl(file, request, argument);
    while (status == -1 && errno == EINTR);
    return status;
}

v4l2_buffer videoBuffer(unsigned int index)
{
    v4l2_buffer buffer = {};
    buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    buffer.memory = V4L2_MEMORY_MMAP;
    buffer.index = index;
    return buffer;
}

} // namespace

VideoCamera::VideoCamera(const std::string& device, int width, int height) :
    _name("camera \"" + base::printable(device) + "\": "),
    _width(width),
    _height(height)
{
    _file = ::open(device.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    if (_file < 0) fail();
    try
    {
        stream();
    }
    catch (...)
    {
        close();
        throw;
    }
}

void VideoCamera::fail() const
{
    throw base::InputError(_name + std::generic_category().message(errno));
}

VideoCamera::~VideoCamera()
{
    close();
}

void VideoCamera::close()
{
    for (const Buffer& buffer : _buffers)
        munmap(buffer.begin, buffer.size);
    _buffers.clear();
    if (_file >= 0) ::close(_file);
    _file = -1;
}

void VideoCamera::stream()
{
    v4l2_format format = {};
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    for (const std::uint32_t pixels : {V4L2_PIX_FMT_GREY, V4L2_PIX_FMT_YUYV})
    {
        format.fmt.pix.width = static_cast<std::uint32_t>(_width);
        format.fmt.pix.height = static_cast<std::uint32_t>(_height);
        format.fmt.pix.pixelformat = pixels;
        format.fmt.pix.field = V4L2_FIELD_NONE;
        if (videoCall(_file, VIDIOC_S_FMT, &format) == -1)
            throw base::InputError(_name + "is no camera that gives images");
        if (format.fmt.pix.pixelformat == pixels) break;
    }
    const v4l2_pix_format& given = format.fmt.pix;
    const bool isGrey = given.pixelformat == V4L2_PIX_FMT_GREY;
    if (!isGrey && given.pixelformat != V4L2_PIX_FMT_YUYV)
        throw base::InputError(_name + "gives neither GREY nor YUYV images");
    if (static_cast<int>(given.width) != _width || static_cast<int>(given.height) != _height)
        throw base::InputError(fmt::format("{}gives {} x {} pixels, not {} x {}",
                                           _name,
                                           given.width,
                                           given.height,
                                           _width,
                                           _height));
    _bytes = isGrey ? 1 : 2;
    _stride = static_cast<int>(given.bytesperline);
    v4l2_requestbuffers wanted = {};
    wanted.count = kVideoBuffers;
    wanted.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    wanted.memory = V4L2_MEMORY_MMAP;
    if (videoCall(_file, VIDIOC_REQBUFS, &wanted) == -1 || wanted.count == 0)
        throw base::InputError(_name + "can't stream images");
    for (unsigned int i = 0; i < wanted.count; ++i)
    {
        v4l2_buffer buffer = videoBuffer(i);
        if (videoCall(_file, VIDIOC_QUERYBUF, &buffer) == -1) fail();
        void* const begin =
            mmap(nullptr, buffer.length, PROT_READ, MAP_SHARED, _file, buffer.m.offset);
        if (begin == MAP_FAILED) fail();
        _buffers.push_back({begin, buffer.length});
        if (videoCall(_file, VIDIOC_QBUF, &buffer) == -1) fail();
    }
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (videoCall(_file, VIDIOC_STREAMON, &type) == -1) fail();
}

bool VideoCamera::next(GrayImage& image)
{
    pollfd ready = {_file, POLLIN, 0};
    if (poll(&ready, 1, kVideoPatience_ms) <= 0) return false;
    v4l2_buffer buffer = videoBuffer(0);
    if (videoCall(_file, VIDIOC_DQBUF, &buffer) == -1)
    {
        if (errno == EAGAIN) return false;
        fail();
    }
    const Buffer& from = _buffers[buffer.index % _buffers.size()];
    image.width = _width;
    image.height = _height;
    image.pixels.assign(static_cast<std::size_t>(_width) * static_cast<std::size_t>(_height), 0);
    const auto* const bytes = static_cast<const std::uint8_t*>(from.begin);
    const std::size_t rows = from.size / static_cast<std::size_t>(_stride > 0 ? _stride : 1);
    for (int y = 0; y < _height && static_cast<std::size_t>(y) < rows; ++y)
        for (int x = 0; x < _width && x * _bytes < _stride; ++x)
            image.at(x, y) = bytes[static_cast<std::size_t>(y) * static_cast<std::size_t>(_stride) +
                                   static_cast<std::size_t>(x * _bytes)];
    videoCall(_file, VIDIOC_QBUF, &buffer);
    return true;
}

} // namespace midair::bridge
