#include "plugin/hands/HandTracker.h"

#include "haptics/base/ThrownBy.h"
#include "haptics/base/threads/SteadyClock.h"
#include "plugin/extending/HandSourceRegistry.h"
#include "plugin/hands/HandConversion.h"
#include "plugin/hands/OpeningHands.h"
#include "plugin/settings/RecordedUri.h"

#include <osgMidair/HapticPoints>
#include <osgMidair/HapticSurface>

#include <algorithm>
#include <utility>

namespace osgMidair
{

using midair::base::Message;
using midair::base::MessageCode;
using midair::bridge::HapticObject;
using midair::bridge::TouchEvent;

namespace
{

// Between the tries of a source of the application's that can't be made.
constexpr double kLeastPause_s = 1.0;
constexpr double kMostPause_s = 30.0;

// From the drive signal to the skin: 0.24 m of air, and the time in which a transducer's amplitude
// comes up.
constexpr double kSound_s = 0.7e-3 + 0.2e-3;

/// Returns true for two of the same finger and object.
bool isSame(const HandTracker::Told& a, const HandTracker::Told& b)
{
    return a.object == b.object && a.touch.hand == b.touch.hand && a.touch.finger == b.touch.finger;
}

void call(TouchCallback& callback, const HandTracker::Told& told)
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

std::string HandTracker::setSettings(const std::string& uri, double reach_m, bool shadows)
{
    _reach_m = reach_m;
    _shadows = shadows;
    if (uri == _uri) return {};
    _uri = uri;
    _retry = {};
    _failed.clear();
    return openNamed();
}

// Returns what is wrong; empty: nothing. The pauses before the tries to come double.
std::string HandTracker::openNamed()
{
    std::string error;
    const bool isFile = RecordedUri::parse(_uri).has_value();
    _namedSource = isFile ? new OpeningHands(_uri) : openHandSource(_uri, error);
    const bool isOwn = !!HandSourceRegistry::find(_uri.substr(0, _uri.find(':')));
    _retry.pause_s = error.empty() || !isOwn
                         ? 0.0
                         : std::clamp(2.0 * _retry.pause_s, kLeastPause_s, kMostPause_s);
    _retry.at_s = midair::base::steadySeconds() + _retry.pause_s;
    return error;
}

void HandTracker::tryAgain()
{
    if (!(_retry.pause_s > 0.0) || _source || midair::base::steadySeconds() < _retry.at_s) return;
    _failed = openNamed();
}

std::vector<Message> HandTracker::takeMessages()
{
    std::vector<Message> messages;
    if (!_thrown.empty()) messages.push_back(failureOf(std::exchange(_thrown, {})));
    if (!_failed.empty()) messages.push_back({MessageCode::HANDS_OPEN, std::exchange(_failed, {})});
    if (!_impossible.empty() && !std::exchange(_isImpossibleTold, true))
        messages.push_back({MessageCode::HANDS_SOURCE, _impossible});
    for (std::string& message : _predictor.takeMessages())
        messages.push_back({MessageCode::HANDS_PREDICTION, std::move(message)});
    HandSource* source = active();
    if (source && std::exchange(_tellsNoLater, false))
        messages.push_back(
            {MessageCode::HANDS_PREDICTION,
             "prediction is left to the tracker, and the hand source tells no hands "
             "of a later time: they are felt late. prediction=kalman predicts them"});
    if (!source) return messages;
    const std::string thrown = midair::base::thrownBy(
        [&]
        {
            for (std::string& message : source->takeMessages())
                messages.push_back({MessageCode::HANDS_SOURCE, std::move(message)});
        });
    if (!thrown.empty()) messages.push_back(failureOf(thrown));
    return messages;
}

Message HandTracker::failureOf(const std::string& thrown) const
{
    const std::string name =
        _source || _uri.empty() ? "the application's hand source" : "hand source \"" + _uri + "\"";
    return {MessageCode::HANDS_THREW,
            name + " has thrown " + thrown + ": there are no hands while it does"};
}

// A source is the application's code: what it throws is told, and isn't thrown out of a frame.
bool HandTracker::ask(double time_s)
{
    HandSource* source = active();
    if (!source) return false;
    bool any = false;
    _thrown = midair::base::thrownBy(
        [&]
        {
            askAhead(*source);
            any = source->getHands(time_s, _hands);
        });
    return any;
}

double HandTracker::horizon_s() const
{
    return _latency_s + _trackerDelay_s + kSound_s;
}

// Asks the source for the hands of a later time if it is to predict them, and for those of now when
// it isn't any longer.
void HandTracker::askAhead(HandSource& source)
{
    if (_later.source.get() != &source)
    {
        osg::ref_ptr<HandSource> before;
        if (_later.answer == Later::YES && _later.source.lock(before)) before->setHorizon(0.0);
        _later = {&source, Later::NOT_ASKED};
    }
    if (!leavesToTracker())
    {
        if (_later.answer == Later::YES) source.setHorizon(0.0);
        _later.answer = Later::NOT_ASKED;
        return;
    }
    if (_later.answer == Later::NO) return;
    const bool can = source.setHorizon(horizon_s());
    _tellsNoLater = !can;
    _later.answer = can ? Later::YES : Later::NO;
}

void HandTracker::setPrediction(midair::bridge::PredictionMethod method, double trackerDelay_s)
{
    _predictor.setMethod(method);
    _trackerDelay_s = trackerDelay_s;
}

void HandTracker::locate(double time_s,
                         const Eigen::Isometry3d& worldToArray,
                         midair::bridge::HandsAndObstacles& around)
{
    around.reach_m = _reach_m;
    around.shadows = _shadows;
    around.props.clear();
    for (const Obstacle& obstacle : _obstacles)
        around.props.push_back({worldToArray * midair::bridge::toEigen(obstacle.a),
                                worldToArray * midair::bridge::toEigen(obstacle.b),
                                obstacle.radius});
    _frame.time_s = time_s;
    _frame.hands.clear();
    around.hands.clear();
    tryAgain();
    if (ask(time_s))
        for (const Hand& hand : _hands)
            _frame.hands.push_back(toBridge(hand));
    _frame = midair::bridge::transformed(_frame, worldToArray);
    _impossible.clear();
    for (midair::bridge::Hand& hand : _frame.hands)
    {
        const std::string wrong = midair::bridge::leaveOutImpossible(hand);
        if (_impossible.empty()) _impossible = wrong;
    }
    if (_impossible.empty()) _isImpossibleTold = false;
    // With no hands, too: those that were known are lost.
    if (!leavesToTracker() || _later.answer == Later::YES) _predictor.predict(_frame, horizon_s());
    around.hands = midair::bridge::handCapsules(_frame);
}

void HandTracker::touch(const std::vector<HapticObject>& objects,
                        std::shared_ptr<const midair::bridge::PlayedPressure> played)
{
    _touchable.clear();
    for (const HapticObject& object : objects)
        if (object.touchEvents) _touchable.push_back(object);
    // Touches also end when objects or hands are gone, so there is work left until no touch is
    // left.
    if (_touchable.empty() && _proximity.touches() == 0)
    {
        _proximity.clear();
        return;
    }
    _proximity.setPlayed(std::move(played));
    _proximity.update(_touchable, _frame, _frame.time_s);
}

std::vector<HandTracker::Told>
HandTracker::gather(const std::function<osg::Node*(std::uint64_t)>& nodeOf,
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
    for (const TouchEvent& event : _proximity.ongoing())
        add(event);
    for (const TouchEvent& event : _proximity.events())
        add(event);
    for (const Told& told : all)
    {
        const auto known = std::find_if(
            _current.begin(), _current.end(), [&](const Told& one) { return isSame(one, told); });
        if (known != _current.end()) _current.erase(known);
        if (told.kind != TouchEvent::LEAVE) _current.push_back(told);
    }
    for (Told& one : _current)
        one.node = nullptr; // kept alive by the caller alone, while it tells
    return all;
}

std::vector<Touch> HandTracker::current() const
{
    std::vector<Touch> touches;
    for (const Told& one : _current)
        touches.push_back(one.touch);
    return touches;
}

std::vector<Message> HandTracker::tell(const std::vector<Told>& all)
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

int HandTracker::touching() const
{
    return static_cast<int>(_proximity.touches());
}

} // namespace osgMidair
