#include "plugin/display/DisplayHead.h"

#include "engine-bridge/hands/opening/HandOpening.h"
#include "engine-bridge/heads/HeadOpening.h"
#include "plugin/heads/KitHead.h"

#include <memory>
#include <utility>

namespace osgMidair
{

namespace
{

constexpr double kLost_s = 0.2; ///< a head missing for longer is lost
/// From an update traversal to the middle of its picture's scan-out: one and a half frames at 60
/// Hz.
constexpr double kLight_s = 0.025;
constexpr const char* kSceneHead = "scene";

} // namespace

DisplayHead::DisplayHead(const std::string& eye, const Eigen::Isometry3d& before) :
    _from(eye == kSceneHead ? From::SCENE : From::SOURCE),
    _isFixed(eye.rfind("fixed", 0) == 0),
    _tracker([](const std::string& text) { return midair::bridge::openHead(text); }),
    _pose(before)
{
    using midair::bridge::PredictionMethod;
    _tracker.setPrediction(_isFixed ? PredictionMethod::OFF : PredictionMethod::KALMAN, 0.0);
    _tracker.setLatency(kLight_s);
    if (_from == From::SCENE) return;
    std::shared_ptr<midair::bridge::HeadSource> source = midair::bridge::openHead(eye);
    midair::bridge::Head head;
    if (source && source->headAt(0.0, head)) take(head.pose, -1.0);
    // A recording starts when it is first shown.
    if (midair::bridge::RecordedUri::parse(eye))
        source = std::make_shared<midair::bridge::OpeningHead>(source);
    _tracker.setSource(source);
}

void DisplayHead::take(const Eigen::Isometry3d& pose, double time_s)
{
    if (!pose.matrix().allFinite()) return;
    _pose = pose;
    _isKnown = true;
    _seen_s = time_s;
}

void DisplayHead::set(const Eigen::Isometry3d& pose, bool isTracked, double time_s)
{
    _from = From::PROGRAM;
    _tracker.setSource(nullptr);
    _isTracked = isTracked;
    if (isTracked) take(pose, time_s);
}

void DisplayHead::locate(double time_s, const HapticScene* scene)
{
    if (_from == From::SOURCE)
    {
        _tracker.locate(time_s);
        _isTracked = _tracker.head().isTracked;
        if (_isTracked) take(_tracker.head().pose, time_s);
    }
    if (_from == From::SCENE)
    {
        Head head;
        _isTracked = scene && scene->getHead(head);
        if (_isTracked) take(toBridge(head, time_s).pose, time_s);
    }
    if (_isTracked || _seen_s < 0.0) _seen_s = time_s;
    _isLost = !_isTracked && time_s - _seen_s > kLost_s;
    if (!_isTracked) return _given->clear();
    _given->setHead(fromBridge({time_s, _pose, true, 0.0}));
}

void DisplayHead::giveTo(HapticScene& scene) const
{
    const bool rests = _from == From::SOURCE && _isFixed;
    if (rests || _from == From::SCENE) return;
    if (!scene.getHeadSource() && scene.getHeads().empty()) scene.setHeadSource(_given);
}

std::string DisplayHead::status() const
{
    const std::string status = _from == From::SOURCE  ? _tracker.status()
                               : _from == From::SCENE ? "head of the scene"
                                                      : "head set by the program";
    return status + (_isKnown ? "" : ", not seen yet");
}

std::vector<std::string> DisplayHead::takeMessages()
{
    std::vector<std::string> all;
    for (midair::base::Message& message : _tracker.takeMessages())
        all.push_back(std::move(message.text));
    return all;
}

} // namespace osgMidair
