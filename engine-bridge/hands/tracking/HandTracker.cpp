#include "engine-bridge/hands/tracking/HandTracker.h"

#include "engine-bridge/hands/opening/HandOpening.h"
#include "engine-bridge/hands/openxr/OpenXrLending.h"

#include <utility>

namespace midair::bridge
{

using base::Message;
using base::MessageCode;

HandTracker::HandTracker(Opener open) :
    _source({[open = std::move(open)](const std::string& uri) -> std::shared_ptr<HandSource>
             {
                 if (!RecordedUri::parse(uri)) return open(uri);
                 return std::make_shared<FromItsBegin>(
                     std::make_shared<OpeningHands>([open, uri] { return open(uri); }, uri));
             },
             isOwnHands,
             "hand source",
             "there are no hands"})
{
}

std::vector<Message> HandTracker::takeMessages()
{
    std::vector<Message> messages = _source.takeMessages();
    for (std::string& message : _predictor.takeMessages())
        messages.push_back({MessageCode::HANDS_PREDICTION, std::move(message)});
    return messages;
}

std::vector<Message> HandTracker::troubles() const
{
    std::vector<Message> all = _source.troubles();
    if (active() && !_impossible.empty()) all.emplace_back(MessageCode::HANDS_SOURCE, _impossible);
    if (_source.refusesLater())
        all.emplace_back(MessageCode::HANDS_PREDICTION,
                         "prediction is left to the tracker, but the hand source doesn't predict "
                         "hands: they are felt late. prediction=kalman predicts them");
    return all;
}

void HandTracker::setPrediction(PredictionMethod method, double trackerDelay_s)
{
    _predictor.setMethod(method);
    _delay.tracker_s = trackerDelay_s;
}

void HandTracker::locate(double time_s, const Eigen::Isometry3d& worldToArray)
{
    if (_worldToArray && !_worldToArray->isApprox(worldToArray))
        OpenXrLending::one().setRecentred({});
    _worldToArray = worldToArray;
    _frame.hands.clear();
    _source.tryAgain();
    bool any = false;
    const double horizon_s = _delay.total_s();
    const bool isAsked = _source.ask(leavesToTracker() ? horizon_s : -1.0,
                                     [&](HandSource& source)
                                     {
                                         any = source.frameAt(time_s, _frame);
                                         _isShown = source.shownFrame(_shown);
                                     });
    _isShown = _isShown && isAsked;
    _shown.time_s = time_s;
    if (_isShown) _shown = transformed(_shown, worldToArray);
    for (Hand& hand : _shown.hands)
        leaveOutImpossible(hand);
    if (!any || !isAsked) _frame.hands.clear();
    _frame.time_s = time_s;
    _frame.presses = std::exchange(_presses, {});
    if (!_frame.hands.empty()) _frame = transformed(_frame, worldToArray);
    _impossible.clear();
    for (Hand& hand : _frame.hands)
    {
        const std::string wrong = leaveOutImpossible(hand);
        if (_impossible.empty()) _impossible = wrong;
    }
    // Also called without hands: then the known ones are lost.
    if (!leavesToTracker() || _source.tellsLater()) _predictor.predict(_frame, horizon_s);
}

std::string HandTracker::recentred()
{
    return OpenXrLending::one().recentred();
}

void HandTracker::touch(const std::vector<HapticObject>& objects,
                        std::shared_ptr<const PlayedPressure> played)
{
    _touchable.clear();
    for (const HapticObject& object : objects)
        if (object.touchEvents) _touchable.push_back(object);
    // Touches also end when objects or hands are gone, so this continues until no touch is left.
    if (_touchable.empty() && _proximity->touches() == 0)
    {
        _proximity->clear();
        return;
    }
    _proximity->setPlayed(std::move(played));
    _proximity->update(_touchable, _frame, _frame.time_s);
}

} // namespace midair::bridge
