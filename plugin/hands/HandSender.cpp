#include "device/DeviceUri.h"
#include "engine-bridge/hands/osc/OscReceiver.h"
#include "engine-bridge/hands/osc/OscSender.h"
#include "engine-bridge/scene/Convert.h"
#include "haptics/base/text/Number.h"
#include "plugin/extending/ArrayConversion.h"
#include "plugin/hands/KitHands.h"

#include <osgMidair/HandSender>

#include <memory>

namespace osgMidair
{

class HandSender::Part
{
public:
    template<typename To>
    explicit Part(const To& to) : sender(to)
    {
    }

    midair::bridge::OscSender sender;
    std::vector<midair::bridge::Hand> hands;
};

HandSender::HandSender(std::unique_ptr<Part> part) : _part(std::move(part)) {}

HandSender::~HandSender() = default;

osg::ref_ptr<HandSender> HandSender::open(const std::string& uri, std::string& error)
{
    error.clear();
    std::unique_ptr<Part> part;
    const auto open = [&]
    {
        midair::device::DeviceUri to(uri, "receiver of hands");
        if (to.scheme() != "osc") throw to.error("should be osc:?address=..&port=..");
        const midair::bridge::OscOptions options = midair::bridge::takeOscOptions(to);
        to.rejectUnknown();
        part = std::make_unique<Part>(options);
    };
    return succeeds(open, error) ? new HandSender(std::move(part)) : nullptr;
}

osg::ref_ptr<HandSender> HandSender::into(int socket)
{
    return new HandSender(std::make_unique<Part>(socket));
}

bool HandSender::send(const std::vector<Hand>& hands, double time)
{
    _part->hands.clear();
    for (const Hand& hand : hands)
        _part->hands.push_back(toBridge(hand));
    return _part->sender.send(_part->hands, time);
}

bool HandSender::send(const Head& head, double time)
{
    return _part->sender.send({time,
                               midair::bridge::headPose(midair::bridge::toEigen(head.position),
                                                        midair::bridge::toEigen(head.orientation)),
                               true,
                               head.age});
}

bool HandSender::say(const std::string& text)
{
    return _part->sender.say(text);
}

bool HandSender::listen()
{
    return _part->sender.listen();
}

double HandSender::getHorizon() const
{
    return _part->sender.horizon_s();
}

} // namespace osgMidair
