#include "engine-bridge/hands/opening/HandOpening.h"
#include "haptics/base/threads/Forks.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"
#include "plugin/extending/ArrayConversion.h"
#include "plugin/extending/MadeBy.h"
#include "plugin/hands/KitHands.h"
#include "plugin/hands/MouseSource.h"

#include <osgMidair/HandSource>
#include <osgMidair/HandSourceFactory>

#include <utility>

#include <fmt/format.h>

namespace osgMidair
{

namespace bridge = midair::bridge;

namespace
{

const std::vector<std::string> kOfScenes = {"mouse:"};

bool isMouse(const std::string& uri)
{
    return uri == "mouse" || uri == "mouse:";
}

/// Makes a source of the bridge available to an application. Playback begins with the first call.
class BridgedHands : public HandSource
{
public:
    explicit BridgedHands(std::shared_ptr<bridge::HandSource> source) :
        _source(
            [source = std::move(source)](bool isFirst)
            {
                // The child of a fork has none.
                if (isFirst) return std::make_unique<bridge::FromItsBegin>(source);
                return std::make_unique<bridge::FromItsBegin>(
                    std::make_shared<bridge::InjectedHandSource>());
            })
    {
    }

    bool getHands(double time, std::vector<Hand>& hands) override
    {
        const bool any = _source->frameAt(time, _frame);
        hands.clear();
        for (const bridge::Hand& hand : _frame.hands)
            hands.push_back(fromBridge(hand));
        return any;
    }
    bool setHorizon(double ahead) override { return _source->setHorizon(ahead); }
    std::string getStatus() const override { return _source->status(); }
    std::vector<std::string> takeMessages() override { return _source->takeMessages(); }

private:
    midair::base::OfProcess<bridge::FromItsBegin> _source;
    bridge::HandFrame _frame;
};

} // namespace

bool KitHands::frameAt(double time_s, bridge::HandFrame& frame)
{
    const bool any = _source->getHands(time_s, _hands);
    frame.hands.clear();
    if (any)
        for (const Hand& hand : _hands)
            frame.hands.push_back(toBridge(hand));
    return any;
}

struct InjectedHands::Injected
{
    midair::base::Mutex mutex;
    std::vector<Hand> hands MIDAIR_GUARDED_BY(mutex);
    double set_s MIDAIR_GUARDED_BY(mutex) = 0.0; ///< steady clock
    unsigned int set MIDAIR_GUARDED_BY(mutex) = 0;
};

InjectedHands::InjectedHands() : _injected(std::make_unique<Injected>()) {}

InjectedHands::~InjectedHands() = default;

void InjectedHands::setHands(const std::vector<Hand>& hands)
{
    const midair::base::Lock lock(_injected->mutex);
    _injected->hands = hands;
    _injected->set_s = midair::base::steadySeconds();
    ++_injected->set;
}

bool InjectedHands::getHands(double /*time*/, std::vector<Hand>& hands)
{
    const midair::base::Lock lock(_injected->mutex);
    hands = _injected->hands;
    for (Hand& hand : hands)
        hand.age += midair::base::steadySeconds() - _injected->set_s;
    return !hands.empty();
}

std::string InjectedHands::getStatus() const
{
    const midair::base::Lock lock(_injected->mutex);
    return fmt::format("hands set by the application, {} times", _injected->set);
}

bool registerHandSource(const std::string& name, HandSourceFactory make, std::string& error)
{
    bridge::HandSourceMaker maker;
    if (make)
        maker = [make = std::move(make)](const std::string& options)
        { return std::make_shared<KitHands>(madeBy<HandSource>(make, options).get()); };
    return bridge::registerHands(name, std::move(maker), error);
}

std::string unknownSceneHands(const std::string& uri)
{
    return isMouse(uri) ? "" : bridge::unknownHands(uri, kOfScenes);
}

std::shared_ptr<bridge::HandSource> openSceneHands(const std::string& uri)
{
    if (isMouse(uri)) return std::make_shared<KitHands>(new MouseSource);
    return bridge::openHands(uri, kOfScenes);
}

osg::ref_ptr<HandSource> openHandSource(const std::string& uri, std::string& error)
{
    std::shared_ptr<bridge::HandSource> source;
    if (!succeeds([&] { source = openSceneHands(uri); }, error) || !source) return nullptr;
    if (HandSource* own = KitHands::of(source.get())) return own;
    return new BridgedHands(source);
}

Hand openHand(int id, const osg::Vec3d& tip, const osg::Quat& orientation)
{
    return fromBridge(bridge::openHandWithIndexTipAt(
        id,
        Eigen::Vector3d(tip.x(), tip.y(), tip.z()),
        Eigen::Quaterniond(orientation.w(), orientation.x(), orientation.y(), orientation.z())));
}

} // namespace osgMidair
