#include "samples/shared/monitor/SceneMonitor.h"

#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"
#include "samples/shared/monitor/page/MonitorAccess.h"

#include <osg/Image>
#include <osg/RenderInfo>
#include <osg/Viewport>
#include <osgDB/Registry>

#include <algorithm>
#include <exception>
#include <sstream>
#include <utility>

#include <CLI/CLI.hpp>

namespace midair::samples
{

namespace
{

constexpr int kWidth = 640;
constexpr double kInterval_s = 0.5; ///< shortest time between two pictures
constexpr double kAsked_s = 3.0;    ///< how long a request keeps pictures coming
constexpr double kFirstWait_s = 0.4;
/// If the picture is older, newest() waits for a new one.
constexpr double kOldPicture_s = 1.0;

} // namespace

/// Pictures of what a camera draws, at most 640 pixels wide, as JPEG. The drawing thread only reads
/// the pixels; the caller of newest() scales and encodes them.
class SceneMonitor::Picture
{
public:
    Picture() : _writer(osgDB::Registry::instance()->getReaderWriterForExtension("jpg"))
    {
        sayProblem(_writer ? "there is no picture yet"
                           : "OpenSceneGraph's plugin for JPEG is missing");
    }

    void sayProblem(const std::string& why)
    {
        const base::Lock lock(_mutex);
        _cost.problem = why;
    }
    /// Called when drawing begins.
    void begin()
    {
        const base::Lock lock(_mutex);
        _isShown = true;
    }
    bool isDue(double now_s)
    {
        const base::Lock lock(_mutex);
        return now_s < _askedUntil_s && now_s - _taken_s >= kInterval_s;
    }

    /// Reads the drawn picture, on the drawing thread.
    void take(const osg::Viewport& viewport)
    {
        const double begin_s = base::steadySeconds();
        const osg::ref_ptr<osg::Image> image = new osg::Image;
        image->readPixels(static_cast<int>(viewport.x()),
                          static_cast<int>(viewport.y()),
                          static_cast<int>(viewport.width()),
                          static_cast<int>(viewport.height()),
                          GL_RGB,
                          GL_UNSIGNED_BYTE);
        const base::Lock lock(_mutex);
        _image = image;
        _taken_s = begin_s;
        _cost.problem.clear();
        ++_cost.count;
        _cost.last_ms = 1e3 * (base::steadySeconds() - begin_s);
        _cost.most_ms = std::max(_cost.most_ms, _cost.last_ms);
        _cost.sum_ms += _cost.last_ms;
        _changed.notifyAll();
    }

    MonitorPicture newest()
    {
        const double now_s = base::steadySeconds();
        osg::ref_ptr<osg::Image> image;
        double taken_s = 0.0;
        {
            base::Lock lock(_mutex);
            if (_writer) _askedUntil_s = now_s + kAsked_s;
            if (!_isWaitedFor && _isShown)
            {
                _isWaitedFor = true;
                while (_taken_s <= now_s - kOldPicture_s &&
                       _changed.waitUntil_s(lock, now_s + kFirstWait_s))
                {
                }
                _isWaitedFor = false;
            }
            image = _image;
            taken_s = _taken_s;
        }
        const base::Lock lock(_encoding);
        if (!image || !_writer || _encoded.taken_s >= taken_s) return _encoded;
        if (image->s() > kWidth) image->scaleImage(kWidth, image->t() * kWidth / image->s(), 1);
        std::ostringstream out;
        const osg::ref_ptr<osgDB::Options> options = new osgDB::Options("JPEG_QUALITY 82");
        if (!_writer->writeImage(*image, out, options).success())
        {
            sayProblem("the picture can't be written as JPEG");
            return {};
        }
        _encoded = {out.str(), taken_s};
        return _encoded;
    }

    PictureCost cost() const
    {
        const base::Lock lock(_mutex);
        return _cost;
    }

private:
    const osg::ref_ptr<osgDB::ReaderWriter> _writer;
    mutable base::Mutex _mutex; ///< held only to copy pointers and numbers
    base::Condition _changed;
    osg::ref_ptr<osg::Image> _image MIDAIR_GUARDED_BY(_mutex); ///< the newest
    double _taken_s MIDAIR_GUARDED_BY(_mutex) = 0.0;
    PictureCost _cost MIDAIR_GUARDED_BY(_mutex);
    bool _isShown MIDAIR_GUARDED_BY(_mutex) = false;
    double _askedUntil_s MIDAIR_GUARDED_BY(_mutex) = 0.0;
    /// Only one caller waits; others get the newest picture at once.
    bool _isWaitedFor MIDAIR_GUARDED_BY(_mutex) = false;

    base::Mutex _encoding; ///< locked before _mutex
    MonitorPicture _encoded MIDAIR_GUARDED_BY(_encoding);
};

/// Reads back the drawn picture.
class SceneMonitor::Readback : public osg::Camera::DrawCallback
{
public:
    explicit Readback(std::shared_ptr<Picture> picture) : _picture(std::move(picture)) {}

    void operator()(osg::RenderInfo& info) const override
    {
        const osg::Viewport* const viewport = info.getCurrentCamera()->getViewport();
        if (viewport && viewport->valid() && _picture->isDue(base::steadySeconds()))
            _picture->take(*viewport);
    }

private:
    const std::shared_ptr<Picture> _picture;
};

/// Adapts a HapticScene to the page.
class SceneMonitor::Source : public MonitorSource
{
public:
    Source(osgMidair::HapticScene& scene, std::function<void()> followMute) :
        _scene(&scene),
        _followMute(std::move(followMute))
    {
    }

    MonitorReading read() const override
    {
        MonitorReading reading{_scene->getStatistics(), _scene->getMuted(), {}};
        const osg::ref_ptr<const osgMidair::HapticField> field = _scene->getField();
        const auto array = field ? field->getArray() : nullptr;
        if (array) reading.array = array->name;
        return reading;
    }
    void setMuted(bool muted) override
    {
        _scene->setMuted(muted);
        if (_followMute) _followMute();
    }

    void silence() { _scene->silence(); }
    MonitorPicture picture() override { return drawn->newest(); }
    PictureCost pictureCost() const override { return drawn->cost(); }

    const std::shared_ptr<Picture> drawn = std::make_shared<Picture>();

private:
    const osg::ref_ptr<osgMidair::HapticScene> _scene;
    const std::function<void()> _followMute;
};

SceneMonitor::SceneMonitor(const MonitorOptions& options,
                           osgMidair::HapticScene& scene,
                           const std::string& name,
                           std::function<void()> followMute)
{
    if (options.address.empty()) return;
    _source = std::make_shared<Source>(scene, std::move(followMute));
    _monitor = std::make_shared<Monitor>(options, name, _source);
}

SceneMonitor::~SceneMonitor()
{
    // No frames come while the page waits for its last requests.
    if (_source) _source->silence();
}

void SceneMonitor::show(osg::Camera& camera)
{
    if (!_source) return;
    camera.addFinalDrawCallback(new Readback(_source->drawn));
    _source->drawn->begin();
}

void SceneMonitor::showNothing(const std::string& why)
{
    if (_source) _source->drawn->sayProblem(why);
}

void addMonitorOptions(CLI::App& app, MonitorOptions& options)
{
    const auto problemOf = [](const std::string& address) -> std::string
    {
        try
        {
            MonitorAddress::parse(address);
        }
        catch (const std::exception& error)
        {
            return error.what();
        }
        return {};
    };
    app.add_option("--monitor",
                   options.address,
                   "Serve the operator's page (state, picture, figures, mute) at this address; "
                   "\":8080\" is 127.0.0.1:8080, for this machine only")
        ->type_name("ADDRESS:PORT")
        ->check(CLI::Validator(problemOf, ""))
        ->group("The operator's page");
    app.add_option("--monitor-token-file",
                   options.tokenFile,
                   "File with the token for mute and unmute; created if missing [print a new token "
                   "at each start]")
        ->type_name("FILE")
        ->group("The operator's page");
    app.add_option("--monitor-host",
                   options.hosts,
                   "Additional host name of the page, for example behind a proxy; repeatable")
        ->type_name("NAME")
        ->group("The operator's page");
}

} // namespace midair::samples
