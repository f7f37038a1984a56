#include "plugin/hands/HandTracker.h"

#include "plugin/hands/HandConversion.h"
#include "plugin/hands/OpeningHands.h"

#include <osgMidair/HapticSurface>

#include <algorithm>

namespace osgMidair
{

using midair::bridge::HapticObject;
using midair::bridge::HologramResult;
using midair::bridge::TouchEvent;

namespace
{

/// Returns the peak pressure that the newest field plays for a relative pressure of 1; 0: not
/// known.
double relativePressure_Pa(const HologramResult* newest, const std::vector<HapticObject>& objects)
{
    if (!newest || newest->points.size() == 0) return 0.0;
    double strongest_Pa = 0.0;
    for (const HapticObject& object : objects)
        if (object.properties.pressureInPa)
            strongest_Pa = std::max(strongest_Pa, object.properties.pressure);
    if (newest->points.absolute) return strongest_Pa;
    const double largest = newest->points.targets.maxCoeff();
    return largest > 0.0 ? newest->report().level_Pa / largest : 0.0;
}

} // namespace

std::string HandTracker::setSettings(const std::string& uri, double reach_m, bool shadows)
{
    _reach_m = reach_m;
    _shadows = shadows;
    if (uri == _uri) return {};
    _uri = uri;
    std::string error;
    const bool isFile = uri.compare(0, 9, "recorded:") == 0;
    _namedSource = isFile ? new OpeningHands(uri) : openHandSource(uri, error);
    return error;
}

std::vector<std::string> HandTracker::takeMessages()
{
    HandSource* source = active();
    return source ? source->takeMessages() : std::vector<std::string>();
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
    HandSource* source = active();
    if (!source || !source->getHands(time_s, _hands)) return;
    for (const Hand& hand : _hands)
        _frame.hands.push_back(toBridge(hand));
    _frame = midair::bridge::transformed(_frame, worldToArray);
    around.hands = midair::bridge::handCapsules(_frame);
}

void HandTracker::touch(const std::vector<HapticObject>& objects, const HologramResult* newest)
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
    _proximity.setRelativePressure(relativePressure_Pa(newest, objects));
    _proximity.update(_touchable, _frame, _frame.time_s);
}

void HandTracker::tell(const std::function<osg::Node*(std::uint64_t)>& nodeOf,
                       const Eigen::Affine3d& arrayToScene)
{
    if (_proximity.events().empty()) return;
    const std::vector<TouchEvent> events =
        _proximity.events(); // a copy, as a callback may start another update
    for (const TouchEvent& event : events)
    {
        Touch touch;
        const osg::ref_ptr<osg::Node> node = nodeOf(event.object);
        touch.node = node;
        touch.path = event.path;
        touch.hand = event.contact.hand;
        touch.bone = midair::bridge::boneName(event.contact.bone);
        touch.time = event.time_s;
        touch.position =
            midair::bridge::toOsg(Eigen::Vector3d(arrayToScene * event.contact.position));
        touch.distance = event.contact.distance_m;
        touch.area = event.contact.overlap_m2;
        touch.force = event.contact.force_N;
        auto* surface = dynamic_cast<HapticSurface*>(node.get());
        for (TouchCallback* callback :
             {surface ? surface->getTouchCallback() : nullptr, _callback.get()})
        {
            if (!callback) continue;
            const osg::ref_ptr<TouchCallback> keep = callback;
            if (event.kind == TouchEvent::ENTER)
                callback->enter(touch);
            else
                callback->leave(touch);
        }
    }
}

int HandTracker::touching() const
{
    return static_cast<int>(_proximity.touches());
}

} // namespace osgMidair
