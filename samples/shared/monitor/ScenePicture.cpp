#include "samples/shared/monitor/ScenePicture.h"

#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"

#include <osg/BufferObject>
#include <osg/GLExtensions>
#include <osg/Image>
#include <osg/RenderInfo>
#include <osg/Viewport>
#include <osgDB/Registry>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <sstream>

namespace midair::samples
{

namespace
{

constexpr double kWidth = 640.0;
constexpr double kFirstWait_s = 0.4;
/// A picture that is older isn't sent at once: there may be a new one in a moment.
constexpr double kOldPicture_s = 1.0;

/// Returns \a pixels (RGBA) as RGB, made smaller by a whole factor; of each square of pixels it
/// takes the mean of four, which costs the thread that draws a quarter of all.
osg::ref_ptr<osg::Image> smaller(const unsigned char* pixels, int width, int height)
{
    const int factor = std::max(1, static_cast<int>(std::lround(width / kWidth)));
    const int step = factor / 2;
    osg::ref_ptr<osg::Image> image = new osg::Image;
    image->allocateImage(width / factor, height / factor, 1, GL_RGB, GL_UNSIGNED_BYTE, 1);
    for (int y = 0; y < image->t(); ++y)
        for (int x = 0; x < image->s(); ++x)
        {
            const auto at = [&](int dx, int dy)
            {
                const auto row = static_cast<std::size_t>(y * factor + dy);
                return pixels + 4 * (row * static_cast<std::size_t>(width) +
                                     static_cast<std::size_t>(x * factor + dx));
            };
            const unsigned char* const corners[] = {
                at(0, 0), at(step, 0), at(0, step), at(step, step)};
            unsigned char* const to = image->data(x, y);
            for (int channel = 0; channel < 3; ++channel)
                to[channel] =
                    static_cast<unsigned char>((corners[0][channel] + corners[1][channel] +
                                                corners[2][channel] + corners[3][channel] + 2) /
                                               4);
        }
    return image;
}

} // namespace

/// Between the thread that draws and the page's.
struct ScenePicture::Shared
{
    std::atomic<double> askedUntil_s{0.0};
    std::atomic<bool> isShown{false};
    osg::ref_ptr<osgDB::ReaderWriter> writer; ///< set before there are other threads
    mutable base::Mutex mutex;                ///< held for copies of pointers and numbers
    base::Condition changed;
    osg::ref_ptr<osg::Image> image MIDAIR_GUARDED_BY(mutex); ///< the newest
    double taken_s MIDAIR_GUARDED_BY(mutex) = 0.0;
    PictureCost cost MIDAIR_GUARDED_BY(mutex);
    /// By one, and no more: whoever else asks takes what there is.
    bool isWaitedFor MIDAIR_GUARDED_BY(mutex) = false;

    base::Mutex encoding; ///< taken before mutex
    MonitorPicture encoded MIDAIR_GUARDED_BY(encoding);
};

/// Reads back what was drawn. All on the thread that draws.
class ScenePicture::Readback : public osg::Camera::DrawCallback
{
public:
    explicit Readback(std::shared_ptr<Shared> shared) : _shared(std::move(shared)) {}

    void operator()(osg::RenderInfo& info) const override
    {
        const double now_s = base::steadySeconds();
        if (_fence)
            fetch(info, now_s);
        else if (now_s < _shared->askedUntil_s && now_s - _begun_s >= kInterval_s)
            begin(info, now_s);
    }

private:
    void begin(osg::RenderInfo& info, double now_s) const
    {
        const osg::Viewport* const viewport = info.getCurrentCamera()->getViewport();
        if (!viewport || viewport->width() < 1.0 || viewport->height() < 1.0) return;
        _begun_s = now_s;
        _width = static_cast<int>(viewport->width());
        _height = static_cast<int>(viewport->height());
        const auto x = static_cast<int>(viewport->x());
        const auto y = static_cast<int>(viewport->y());
        const auto* const gl = info.getState()->get<osg::GLExtensions>();
        const auto bytes =
            4U * static_cast<unsigned int>(_width) * static_cast<unsigned int>(_height);
        glPixelStorei(GL_PACK_ALIGNMENT, 4);
        glPixelStorei(GL_PACK_ROW_LENGTH, 0);
        if (gl->isPBOSupported && gl->glFenceSync && gl->glClientWaitSync)
        {
            gl->glGenBuffers(1, &_buffer);
            gl->glBindBuffer(GL_PIXEL_PACK_BUFFER_ARB, _buffer);
            gl->glBufferData(GL_PIXEL_PACK_BUFFER_ARB, bytes, nullptr, GL_STREAM_READ_ARB);
            glReadPixels(x, y, _width, _height, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
            gl->glBindBuffer(GL_PIXEL_PACK_BUFFER_ARB, 0);
            _fence = gl->glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
            _spent_ms = 1e3 * (base::steadySeconds() - now_s);
            return;
        }
        _pixels.resize(bytes);
        glReadPixels(x, y, _width, _height, GL_RGBA, GL_UNSIGNED_BYTE, _pixels.data());
        _spent_ms = 0.0;
        keep(_pixels.data(), now_s);
    }

    void fetch(osg::RenderInfo& info, double now_s) const
    {
        const auto* const gl = info.getState()->get<osg::GLExtensions>();
        if (gl->glClientWaitSync(_fence, GL_SYNC_FLUSH_COMMANDS_BIT, 0) == GL_TIMEOUT_EXPIRED)
            return;
        gl->glDeleteSync(_fence);
        _fence = nullptr;
        gl->glBindBuffer(GL_PIXEL_PACK_BUFFER_ARB, _buffer);
        const void* const pixels = gl->glMapBuffer(GL_PIXEL_PACK_BUFFER_ARB, GL_READ_ONLY_ARB);
        if (pixels)
        {
            keep(static_cast<const unsigned char*>(pixels), now_s);
            gl->glUnmapBuffer(GL_PIXEL_PACK_BUFFER_ARB);
        }
        gl->glBindBuffer(GL_PIXEL_PACK_BUFFER_ARB, 0);
        gl->glDeleteBuffers(1, &_buffer);
    }

    /// Hands over the picture whose reading was begun at _begun_s; \a now_s: when this frame's
    /// share of the work began.
    void keep(const unsigned char* pixels, double now_s) const
    {
        const osg::ref_ptr<osg::Image> image = smaller(pixels, _width, _height);
        {
            const base::Lock lock(_shared->mutex);
            _shared->image = image;
            _shared->taken_s = _begun_s;
            PictureCost& cost = _shared->cost;
            cost.problem.clear();
            ++cost.count;
            cost.last_ms = _spent_ms + 1e3 * (base::steadySeconds() - now_s);
            cost.most_ms = std::max(cost.most_ms, cost.last_ms);
            cost.sum_ms += cost.last_ms;
        }
        _shared->changed.notifyAll();
    }

    std::shared_ptr<Shared> _shared;
    mutable GLuint _buffer = 0;                 ///< lives as long as the fence
    mutable std::vector<unsigned char> _pixels; ///< where there are no pixel buffers
    mutable GLsync _fence = nullptr;            ///< set: pixels are on their way
    mutable double _begun_s = 0.0;
    mutable double _spent_ms = 0.0;
    mutable int _width = 0;
    mutable int _height = 0;
};

ScenePicture::ScenePicture() : _shared(std::make_shared<Shared>())
{
    _shared->writer = osgDB::Registry::instance()->getReaderWriterForExtension("jpg");
    const base::Lock lock(_shared->mutex);
    _shared->cost.problem =
        _shared->writer ? "there is no picture yet" : "OpenSceneGraph's plugin for JPEG is missing";
}

ScenePicture::~ScenePicture()
{
    end();
}

void ScenePicture::show(osg::Camera& camera)
{
    camera.addFinalDrawCallback(new Readback(_shared));
    _shared->isShown = true;
}

void ScenePicture::showNothing(const std::string& why)
{
    const base::Lock lock(_shared->mutex);
    _shared->cost.problem = why;
}

void ScenePicture::end()
{
    _shared->askedUntil_s = -1.0;
}

MonitorPicture ScenePicture::newest()
{
    const double now_s = base::steadySeconds();
    if (_shared->writer) _shared->askedUntil_s = now_s + kAsked_s;
    osg::ref_ptr<osg::Image> image;
    double taken_s = 0.0;
    {
        base::Lock lock(_shared->mutex);
        if (!_shared->isWaitedFor && _shared->isShown)
        {
            _shared->isWaitedFor = true;
            const double end_s = now_s + kFirstWait_s;
            while (_shared->taken_s <= now_s - kOldPicture_s &&
                   _shared->changed.waitUntil_s(lock, end_s))
            {
            }
            _shared->isWaitedFor = false;
        }
        image = _shared->image;
        taken_s = _shared->taken_s;
    }
    const base::Lock lock(_shared->encoding);
    if (!image || !_shared->writer || _shared->encoded.taken_s >= taken_s) return _shared->encoded;
    std::ostringstream out;
    const osg::ref_ptr<osgDB::Options> options = new osgDB::Options("JPEG_QUALITY 82");
    if (!_shared->writer->writeImage(*image, out, options).success()) return {};
    _shared->encoded = {out.str(), "image/jpeg", taken_s};
    return _shared->encoded;
}

PictureCost ScenePicture::cost() const
{
    const base::Lock lock(_shared->mutex);
    return _shared->cost;
}

} // namespace midair::samples
