#pragma once

#include "engine-bridge/tags/GrayImage.h"

#include <cstddef>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Takes images from a camera of Video4Linux. For one thread.
class VideoCamera
{
public:
    /// Opens \a device ("/dev/video0") for images of \a width x \a height pixels. Throws
    /// base::InputError with the supported format.
    VideoCamera(const std::string& device, int width, int height);
    ~VideoCamera();
    VideoCamera(const VideoCamera&) = delete;
    VideoCamera& operator=(const VideoCamera&) = delete;

    /// Waits at most 0.2 s for the next image. Returns false if there was none. Throws
    /// base::InputError once the camera is gone.
    bool next(GrayImage& image);

private:
    struct Buffer
    {
        void* begin = nullptr;
        std::size_t size = 0;
    };

    void stream();
    [[noreturn]] void fail() const; ///< with the text of errno
    void close();

    std::string _name;
    int _file = -1;
    int _width, _height;
    int _bytes = 1;  ///< per pixel; the first is the brightness
    int _stride = 0; ///< bytes per row
    std::vector<Buffer> _buffers;
};

} // namespace midair::bridge
