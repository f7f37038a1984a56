#include "engine-bridge/hands/opening/HandOpening.h"
#include "engine-bridge/heads/HeadOpening.h"
#include "haptics/base/threads/Forks.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"
#include "plugin/extending/ArrayConversion.h"
#include "plugin/extending/MadeBy.h"
#include "plugin/heads/KitHead.h"
#include "plugin/heads/MouseHead.h"

#include <osgMidair/HeadSource>

#include <optional>
#include <utility>

#include <fmt/format.h>

namespace osgMidair
{

namespace bridge = midair::bridge;

namespace
{

const std::vector<std::string> kHeadsOfScenes = {"mouse:"};

bool isMouseHead(const std::string& text)
{
    return text == "mouse" || text == "mouse:";
}

/// Makes a source of the bridge available to an application; the child of a fork has no head.
class BridgedHead : public HeadSource
{
public:
    explicit BridgedHead(std::shared_ptr<bridge::HeadSource> source) :
        _source(
            [source = std::move(source)](bool isFirst)
            {
                std::shared_ptr<bridge::HeadSource> used = source;
                if (!isFirst) used = std::make_shared<bridge::InjectedHeadSource>();
                return std::make_unique<std::shared_ptr<bridge::HeadSource>>(std::move(used));
            })
    {
    }

    bool getHead(double time, Head& head) override
    {
        bridge::Head seen;
        const bool isTracked = (*_source)->headAt(time, seen);
        if (isTracked) head = fromBridge(seen);
        return isTracked;
    }
    bool setHorizon(double ahead) override { return (*_source)->setHorizon(ahead); }
    std::string getStatus() const override { return (*_source)->status(); }
    std::vector<std::string> takeMessages() override { return (*_source)->takeMessages(); }

private:
    midair::base::OfProcess<std::shared_ptr<bridge::HeadSource>> _source;
};

} // namespace

bool KitHead::headAt(double time_s, bridge::Head& head)
{
    Head seen;
    head = {time_s, Eigen::Isometry3d::Identity(), _source->getHead(time_s, seen), seen.age};
    if (head.isTracked) head = toBridge(seen, time_s);
    return head.isTracked;
}

struct InjectedHead::Injected
{
    midair::base::Mutex mutex;
    std::optional<Head> head MIDAIR_GUARDED_BY(mutex);
    double set_s MIDAIR_GUARDED_BY(mutex) = 0.0; ///< steady clock
    unsigned int set MIDAIR_GUARDED_BY(mutex) = 0;
};

InjectedHead::InjectedHead() : _injected(std::make_unique<Injected>()) {}

InjectedHead::~InjectedHead() = default;

void InjectedHead::setHead(const Head& head)
{
    const midair::base::Lock lock(_injected->mutex);
    _injected->head = head;
    _injected->set_s = midair::base::steadySeconds();
    ++_injected->set;
}

void InjectedHead::clear()
{
    const midair::base::Lock lock(_injected->mutex);
    _injected->head.reset();
}

bool InjectedHead::getHead(double /*time*/, Head& head)
{
    const midair::base::Lock lock(_injected->mutex);
    if (!_injected->head) return false;
    head = *_injected->head;
    head.age += midair::base::steadySeconds() - _injected->set_s;
    return true;
}

std::string InjectedHead::getStatus() const
{
    const midair::base::Lock lock(_injected->mutex);
    return fmt::format("head set by the application, {} times", _injected->set);
}

bool registerHeadSource(const std::string& name, HeadSourceFactory make, std::string& error)
{
    bridge::HeadSourceMaker maker;
    if (make)
        maker = [make = std::move(make)](const std::string& options)
        { return std::make_shared<KitHead>(madeBy<HeadSource>(make, options).get()); };
    return bridge::registerHeads(name, std::move(maker), error);
}

std::string unknownSceneHead(const std::string& text)
{
    return isMouseHead(text) ? "" : bridge::unknownHead(text, kHeadsOfScenes);
}

std::shared_ptr<bridge::HeadSource> openSceneHead(const std::string& text)
{
    if (isMouseHead(text)) return std::make_shared<KitHead>(new MouseHead);
    return bridge::openHead(text, kHeadsOfScenes);
}

osg::ref_ptr<HeadSource> openHeadSource(const std::string& text, std::string& error)
{
    std::shared_ptr<bridge::HeadSource> source;
    const auto open = [&]
    {
        source = openSceneHead(text);
        if (bridge::RecordedUri::parse(text)) // starts with the first call
            source = std::make_shared<bridge::OpeningHead>(source);
    };
    if (!succeeds(open, error) || !source) return nullptr;
    if (HeadSource* own = KitHead::of(source.get())) return own;
    return new BridgedHead(source);
}

} // namespace osgMidair
