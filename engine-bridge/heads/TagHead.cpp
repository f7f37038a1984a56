#include "engine-bridge/heads/TagHead.h"

#include "engine-bridge/tags/VideoCamera.h"
#include "haptics/base/InputError.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

constexpr double kImagesEvery_s = 1.0 / 30.0; ///< for images from files

} // namespace

struct TagHead::Inside
{
    explicit Inside(TagRig given) : rig(std::move(given)) {}

    const TagRig rig;
    TagDetector detector;
    std::unique_ptr<VideoCamera> camera; ///< null: images from files
    std::size_t taken = 0;               ///< images

    base::Mutex mutex;
    Head head MIDAIR_GUARDED_BY(mutex); ///< its time is on the steady clock
    int tags MIDAIR_GUARDED_BY(mutex) = 0;
    std::vector<std::string> messages MIDAIR_GUARDED_BY(mutex);

    /// Waits for an image; returns false if there was none.
    bool next(GrayImage& image)
    {
        if (camera) return camera->next(image);
        image = readPgm(rig.images[std::min(taken, rig.images.size() - 1)]);
        ++taken;
        std::this_thread::sleep_for(std::chrono::duration<double>(kImagesEvery_s));
        return true;
    }

    void look(const GrayImage& image, double time_s)
    {
        if (image.width != rig.camera.width || image.height != rig.camera.height)
            throw base::InputError(fmt::format("an image has {} x {} pixels, the camera {} x {}",
                                               image.width,
                                               image.height,
                                               rig.camera.width,
                                               rig.camera.height));
        const std::vector<TagSeen> seen = detector.detect(image);
        const std::optional<Eigen::Isometry3d> pose = cameraPose(rig, seen);
        const base::Lock lock(mutex);
        tags = static_cast<int>(seen.size());
        if (pose) head = {time_s, headOf(rig, *pose), true, 0.0};
    }
};

TagHead::TagHead(TagRig rig) : _inside(std::make_unique<Inside>(std::move(rig)))
{
    const TagRig& own = _inside->rig;
    if (!own.device.empty())
        _inside->camera =
            std::make_unique<VideoCamera>(own.device, own.camera.width, own.camera.height);
    else if (own.images.empty())
        throw base::InputError("the camera has neither a device nor images");
    _thread = std::thread([this] { run(); });
}

TagHead::~TagHead()
{
    _isEnding = true;
    _thread.join();
}

void TagHead::run()
{
    const std::string thrown = base::thrownBy(
        [&]
        {
            GrayImage image;
            while (!_isEnding)
            {
                const bool isTaken = _inside->next(image);
                if (isTaken) _inside->look(image, base::steadySeconds());
            }
        });
    if (thrown.empty()) return;
    const base::Lock lock(_inside->mutex);
    _inside->messages.push_back("the camera failed: " + thrown);
}

bool TagHead::headAt(double time_s, Head& head)
{
    const double now_s = base::steadySeconds();
    const base::Lock lock(_inside->mutex);
    head = _inside->head;
    head.age_s = std::max(0.0, now_s - head.time_s);
    head.time_s = time_s;
    head.isTracked = head.isTracked && head.age_s <= kStale_s;
    return head.isTracked;
}

std::string TagHead::status() const
{
    const base::Lock lock(_inside->mutex);
    return fmt::format("camera {}, {} tags seen",
                       _inside->camera ? _inside->rig.device : std::string("images"),
                       _inside->tags);
}

std::vector<std::string> TagHead::takeMessages()
{
    const base::Lock lock(_inside->mutex);
    return std::exchange(_inside->messages, {});
}

} // namespace midair::bridge
