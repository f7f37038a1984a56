#include "engine-bridge/heads/HeadTracker.h"

#include "engine-bridge/hands/opening/HandOpening.h"
#include "engine-bridge/heads/HeadOpening.h"

#include <array>

#include <fmt/format.h>

namespace midair::bridge
{

using base::Message;
using base::MessageCode;

namespace
{

constexpr double kHeadEar_m = 0.08; ///< lateral distance from the midpoint between the eyes

/// The joints of a palm in the head, wide enough for its rotations to be measured.
constexpr std::array<HandJointName, 4> kAround = {
    WRIST, INDEX_PROXIMAL, MIDDLE_PROXIMAL, LITTLE_PROXIMAL};
constexpr double kAround_m = 0.08;

/// Returns a hand that moves with the head, so that the predictor of hands predicts heads.
Hand handIn(const Head& head)
{
    Hand hand;
    hand.id = HandPredictor::kHead;
    hand.age_s = head.age_s;
    const auto place = [&](HandJointName joint, const Eigen::Vector3d& at)
    {
        HandJoint& one = hand.joints[static_cast<std::size_t>(joint)];
        one.position = head.pose * at;
        one.orientation = Eigen::Quaterniond(head.pose.linear());
        one.positionValid = one.orientationValid = true;
    };
    place(PALM, Eigen::Vector3d::Zero());
    for (std::size_t i = 0; i < kAround.size(); ++i)
        place(kAround[i],
              {i % 2 == 0 ? kAround_m : -kAround_m, i < 2 ? kAround_m : -kAround_m, 0.0});
    return hand;
}

/// Returns the problem of a tracked head; empty: none.
std::string wrongHead(const Head& head)
{
    constexpr double kTolerance = 1e-3;
    const Eigen::Vector3d place = head.pose.translation();
    const Eigen::Matrix3d turn = head.pose.linear();
    // Also false for NaN.
    const bool isPlace = place.norm() <= kFarthestJoint_m;
    const bool isTurn = turn.isUnitary(kTolerance) && turn.determinant() > 0.0;
    if (isPlace && isTurn) return {};
    return isPlace ? std::string("the head's pose is not rigid: the head is treated as lost")
                   : fmt::format("the head is at {:g} {:g} {:g} m, should be within 1000 m: the "
                                 "head is treated as lost",
                                 place.x(),
                                 place.y(),
                                 place.z());
}

} // namespace

Eigen::Matrix<double, 3, 2> earsOf(const Eigen::Isometry3d& pose)
{
    Eigen::Matrix<double, 3, 2> ears;
    const Eigen::Vector3d aside = kHeadEar_m * pose.linear().col(0);
    ears << pose.translation() - aside, pose.translation() + aside;
    return ears;
}

HeadTracker::HeadTracker(Opener open) :
    _source({[open = std::move(open)](const std::string& text) -> std::shared_ptr<HeadSource>
             {
                 if (!RecordedUri::parse(text)) return open(text);
                 return std::make_shared<OpeningHead>([open, text] { return open(text); }, text);
             },
             isOwnHead,
             "head source",
             "there is no head"})
{
}

void HeadTracker::setSource(std::shared_ptr<HeadSource> source)
{
    const HeadSource* before = active().get();
    _source.set(std::move(source));
    forget(before);
}

std::string HeadTracker::setNamed(const std::string& text)
{
    if (text == named()) return {};
    const std::shared_ptr<HeadSource> before = active();
    std::string wrong = _source.setNamed(text);
    forget(before.get());
    return wrong;
}

void HeadTracker::forget(const HeadSource* before)
{
    if (active().get() == before) return;
    _head = {};
    _last.reset();
    _impossible.clear();
}

void HeadTracker::setPrediction(PredictionMethod method, double trackerDelay_s)
{
    _predictor.setMethod(method);
    _delay.tracker_s = trackerDelay_s;
}

std::vector<Message> HeadTracker::takeMessages()
{
    std::vector<Message> messages = _source.takeMessages();
    for (std::string& message : _predictor.takeMessages())
        messages.push_back({MessageCode::HANDS_PREDICTION, std::move(message)});
    return messages;
}

std::vector<Message> HeadTracker::troubles() const
{
    std::vector<Message> all = _source.troubles();
    if (!active()) return all;
    if (!_impossible.empty()) all.emplace_back(MessageCode::HANDS_SOURCE, _impossible);
    if (_last && !_head.isTracked)
        all.emplace_back(MessageCode::HANDS_SOURCE,
                         "the head is lost: its last position is used, also for the ear limit");
    if (_source.refusesLater())
        all.emplace_back(MessageCode::HANDS_PREDICTION,
                         "prediction is left to the tracker, but the head source doesn't predict "
                         "the head: its present pose is used. prediction=kalman predicts it");
    return all;
}

void HeadTracker::locate(double time_s)
{
    _source.tryAgain();
    const double horizon_s = _delay.total_s();
    bool isSeen = false;
    const bool isAsked =
        _source.ask(leavesToTracker() ? horizon_s : -1.0,
                    [&](HeadSource& source) { isSeen = source.headAt(time_s, _head); });
    _head.time_s = time_s;
    _head.isTracked = isAsked && isSeen;
    _impossible = _head.isTracked ? wrongHead(_head) : "";
    _head.isTracked = _head.isTracked && _impossible.empty();
    // Also called without a head: then the known one is lost.
    if (!leavesToTracker() || _source.tellsLater()) predict(horizon_s);
    if (_head.isTracked) _last = _head.pose;
}

void HeadTracker::predict(double horizon_s)
{
    HandFrame frame;
    frame.time_s = _head.time_s;
    if (_head.isTracked) frame.hands.push_back(handIn(_head));
    _predictor.predict(frame, horizon_s);
    if (frame.hands.empty()) return;
    const HandJoint& middle = frame.hands.front().joints[PALM];
    _head.pose = headPose(middle.position, middle.orientation);
}

} // namespace midair::bridge
