#include "engine-bridge/hands/tracking/HandTracker.h"

#include "engine-bridge/hands/opening/HandOpening.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace midair::bridge
{

using base::Message;
using base::MessageCode;

namespace
{

// Between the tries of a source of the application's that can't be made.
constexpr double kLeastPause_s = 1.0;
constexpr double kMostPause_s = 30.0;

// From the drive signal to the skin: 0.24 m of air, and the time in which a transducer's amplitude
// comes up.
constexpr double kSound_s = 0.7e-3 + 0.2e-3;

} // namespace

void HandTracker::setSource(std::shared_ptr<HandSource> source)
{
    if (source != _source) askNoLonger();
    _source = std::move(source);
}

std::string HandTracker::setNamed(const std::string& uri)
{
    if (uri == _uri) return {};
    if (!_source) askNoLonger();
    _uri = uri;
    _retry = {};
    return openNamed();
}

// Returns what is wrong; empty: nothing. The pauses before the tries to come double.
std::string HandTracker::openNamed()
{
    std::string error;
    _namedSource.reset();
    try
    {
        _namedSource = RecordedUri::parse(_uri)
                           ? std::make_shared<FromItsBegin>(std::make_shared<OpeningHands>(
                                 [open = _open, uri = _uri] { return open(uri); }, _uri))
                           : _open(_uri);
    }
    catch (const std::runtime_error& wrong) // InputError, DeviceError
    {
        error = wrong.what();
    }
    _retry.failed = error;
    _retry.pause_s = error.empty() || !isOwnHands(_uri)
                         ? 0.0
                         : std::clamp(2.0 * _retry.pause_s, kLeastPause_s, kMostPause_s);
    _retry.at_s = base::steadySeconds() + _retry.pause_s;
    return error;
}

void HandTracker::tryAgain()
{
    if (!(_retry.pause_s > 0.0) || _source || base::steadySeconds() < _retry.at_s) return;
    _retry.isTold = openNamed().empty();
}

std::vector<Message> HandTracker::takeMessages()
{
    std::vector<Message> messages;
    if (!std::exchange(_retry.isTold, true))
        messages.push_back({MessageCode::HANDS_OPEN, _retry.failed}); // once more
    for (std::string& message : _predictor.takeMessages())
        messages.push_back({MessageCode::HANDS_PREDICTION, std::move(message)});
    const std::shared_ptr<HandSource> source = active();
    if (!source) return messages;
    const std::string thrown = base::thrownBy(
        [&]
        {
            for (std::string& message : source->takeMessages())
                messages.push_back({MessageCode::HANDS_SOURCE, std::move(message)});
        });
    if (!thrown.empty()) _trouble.thrown = thrown;
    return messages;
}

std::vector<Message> HandTracker::troubles() const
{
    std::vector<Message> all;
    const bool isAny = active() != nullptr;
    if (!_source && !_retry.failed.empty())
        all.emplace_back(MessageCode::HANDS_OPEN, _retry.failed);
    if (isAny && !_trouble.thrown.empty()) all.push_back(failureOf(_trouble.thrown));
    if (isAny && !_trouble.impossible.empty())
        all.emplace_back(MessageCode::HANDS_SOURCE, _trouble.impossible);
    if (isAny && _later.answer == Later::NO)
        all.emplace_back(MessageCode::HANDS_PREDICTION,
                         "prediction is left to the tracker, and the hand source tells no hands "
                         "of a later time: they are felt late. prediction=kalman predicts them");
    return all;
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
    const std::shared_ptr<HandSource> source = active();
    if (!source) return false;
    bool any = false;
    _trouble.thrown = base::thrownBy(
        [&]
        {
            askAhead(*source);
            any = source->frameAt(time_s, _frame);
        });
    return any && _trouble.thrown.empty();
}

double HandTracker::horizon_s() const
{
    return _latency_s + _trackerDelay_s + kSound_s;
}

// Asks the source for the hands of a later time if it is to predict them, and for those of now when
// it isn't any longer.
void HandTracker::askAhead(HandSource& source)
{
    if (!leavesToTracker())
    {
        if (_later.answer == Later::YES) source.setHorizon(0.0);
        _later.answer = Later::NOT_ASKED;
        return;
    }
    if (_later.answer == Later::NO) return;
    _later.answer = source.setHorizon(horizon_s()) ? Later::YES : Later::NO;
}

// Another source follows. What this one throws is of no interest any more.
void HandTracker::askNoLonger()
{
    const std::shared_ptr<HandSource> source = active();
    if (source && _later.answer == Later::YES) base::thrownBy([&] { source->setHorizon(0.0); });
    _later.answer = Later::NOT_ASKED;
}

void HandTracker::setPrediction(PredictionMethod method, double trackerDelay_s)
{
    _predictor.setMethod(method);
    _trackerDelay_s = trackerDelay_s;
}

void HandTracker::locate(double time_s, const Eigen::Isometry3d& worldToArray)
{
    _frame.hands.clear();
    tryAgain();
    if (!ask(time_s)) _frame.hands.clear();
    _frame.time_s = time_s;
    _frame.presses = std::exchange(_presses, {});
    if (!_frame.hands.empty()) _frame = transformed(_frame, worldToArray);
    _trouble.impossible.clear();
    for (Hand& hand : _frame.hands)
    {
        const std::string wrong = leaveOutImpossible(hand);
        if (_trouble.impossible.empty()) _trouble.impossible = wrong;
    }
    // With no hands, too: those that were known are lost.
    if (!leavesToTracker() || _later.answer == Later::YES) _predictor.predict(_frame, horizon_s());
}

void HandTracker::touch(const std::vector<HapticObject>& objects,
                        std::shared_ptr<const PlayedPressure> played)
{
    _touchable.clear();
    for (const HapticObject& object : objects)
        if (object.touchEvents) _touchable.push_back(object);
    // Touches also end when objects or hands are gone, so there is work left until no touch is
    // left.
    if (_touchable.empty() && _proximity->touches() == 0)
    {
        _proximity->clear();
        return;
    }
    _proximity->setPlayed(std::move(played));
    _proximity->update(_touchable, _frame, _frame.time_s);
}

} // namespace midair::bridge
