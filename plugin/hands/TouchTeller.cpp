#include "plugin/hands/TouchTeller.h"

#include "engine-bridge/scene/Convert.h"
#include "haptics/base/ThrownBy.h"

#include <osgMidair/HapticPoints>
#include <osgMidair/HapticSurface>

#include <algorithm>

namespace osgMidair
{

using midair::base::Message;
using midair::base::MessageCode;
using midair::bridge::TouchEvent;

namespace
{

/// Returns true if both have the same finger and object.
bool isSame(const TouchTeller::Told& a, const TouchTeller::Told& b)
{
    return a.object == b.object && a.touch.hand == b.touch.hand && a.touch.finger == b.touch.finger;
}

void call(TouchCallback& callback, const TouchTeller::Told& told)
{
    switch (told.kind)
    {
    case TouchEvent::ENTER:
        callback.enter(told.touch);
        break;
    case TouchEvent::STAY:
        callback.stay(told.touch);
        break;
    case TouchEvent::LEAVE:
        callback.leave(told.touch);
        break;
    }
}

TouchCallback* callbackOf(osg::Node* node)
{
    if (auto* surface = dynamic_cast<HapticSurface*>(node)) return surface->getTouchCallback();
    if (auto* points = dynamic_cast<HapticPoints*>(node)) return points->getTouchCallback();
    return nullptr;
}

} // namespace

void TouchCallback::stay(const Touch&) {}

std::vector<TouchTeller::Told>
TouchTeller::gather(const midair::bridge::HandProximity& touched,
                    const std::function<osg::Node*(std::uint64_t)>& nodeOf,
                    const Eigen::Affine3d& arrayToScene)
{
    std::vector<Told> all;
    const auto add = [&](const TouchEvent& event)
    {
        Told& told = all.emplace_back();
        told.kind = event.kind;
        told.object = event.object;
        told.node = nodeOf(event.object);
        Touch& touch = told.touch;
        touch.node = told.node;
        touch.path = event.path;
        touch.hand = event.contact.hand;
        touch.finger = static_cast<Touch::Finger>(event.contact.finger);
        touch.bone = midair::bridge::boneName(event.contact.bone);
        touch.time = event.time_s;
        touch.position =
            midair::bridge::toOsg(Eigen::Vector3d(arrayToScene * event.contact.position));
        touch.distance = event.contact.distance_m;
        touch.depth = std::max(0.0, -event.contact.distance_m);
        touch.area = event.contact.overlap_m2;
        touch.force = event.contact.force_N;
    };
    for (const TouchEvent& event : touched.ongoing())
        add(event);
    for (const TouchEvent& event : touched.events())
        add(event);
    for (const Told& told : all)
    {
        const auto known = std::find_if(
            _current.begin(), _current.end(), [&](const Told& one) { return isSame(one, told); });
        if (known != _current.end()) _current.erase(known);
        if (told.kind != TouchEvent::LEAVE) _current.push_back(told);
    }
    for (Told& one : _current)
        one.node = nullptr; // during the callback only the caller keeps it alive
    return all;
}

std::vector<Touch> TouchTeller::current() const
{
    std::vector<Touch> touches;
    for (const Told& one : _current)
        touches.push_back(one.touch);
    return touches;
}

std::vector<Message> TouchTeller::tell(const std::vector<Told>& all)
{
    std::vector<Message> messages;
    for (const Told& told : all)
        for (TouchCallback* callback : {callbackOf(told.node), _callback.get()})
        {
            if (!callback) continue;
            const osg::ref_ptr<TouchCallback> keep = callback;
            const std::string thrown = midair::base::thrownBy([&] { call(*keep, told); });
            if (!thrown.empty())
                messages.push_back(midair::base::about(MessageCode::CALLBACK_THREW,
                                                       told.touch.path,
                                                       "its touch callback has thrown " + thrown));
        }
    return messages;
}

} // namespace osgMidair
