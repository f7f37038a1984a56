#include "samples/experiments/jnd/TrialRunner.h"

#include <utility>

namespace midair::samples
{

void TrialRunner::go(Phase phase, double now_s)
{
    _phase = phase;
    _since_s = now_s;
    _played_s = -1.0;
}

void TrialRunner::begin(double now_s)
{
    _answer.reset();
    go(_times.reference_s > 0.0 ? Phase::REFERENCE : Phase::LINE, now_s);
}

std::optional<double> TrialRunner::wanted() const
{
    if (_phase == Phase::REFERENCE) return 0.0;
    if (_phase == Phase::LINE) return _value;
    return std::nullopt;
}

bool TrialRunner::answer(bool isFelt)
{
    const bool isAsked = (_phase == Phase::LINE && _played_s >= 0.0) || _phase == Phase::ANSWER;
    if (isAsked && !_answer) _answer = isFelt;
    return isAsked;
}

TrialRunner::Step TrialRunner::voidTrial(double now_s, const std::string& why)
{
    Step step;
    step.voided = why;
    _answer.reset();
    go(Phase::STOPPED, now_s);
    return step;
}

TrialRunner::Step TrialRunner::playPhase(double now_s, const PlayedNow& played)
{
    if (!played.isReady) return voidTrial(now_s, played.problem);
    if (!played.isPlayed)
    {
        if (_played_s >= 0.0)
            return voidTrial(now_s, "the line was interrupted: " + played.problem);
        if (now_s - _since_s > kPatience_s)
            return voidTrial(now_s, "the line wasn't played within 5 s: " + played.problem);
        return {};
    }
    if (_played_s < 0.0) _played_s = now_s;
    const double long_s = now_s - _played_s;
    if (_phase == Phase::REFERENCE)
    {
        if (long_s >= _times.reference_s) go(Phase::BETWEEN, now_s);
        return {};
    }
    _line_s = long_s;
    _lineBegin_s = _played_s;
    if (_answer || long_s >= _times.line_s) go(Phase::ANSWER, now_s);
    return {};
}

TrialRunner::Step TrialRunner::step(double now_s, const PlayedNow& played)
{
    Step step;
    switch (_phase)
    {
    case Phase::WAITING:
    case Phase::DONE:
        break;
    case Phase::REFERENCE:
    case Phase::LINE:
        step = playPhase(now_s, played);
        break;
    case Phase::BETWEEN:
        if (!played.isReady) return voidTrial(now_s, played.problem);
        if (now_s - _since_s >= _times.between_s) go(Phase::LINE, now_s);
        break;
    case Phase::RESTING:
    case Phase::STOPPED:
        if (played.isReady && now_s - _since_s >= _times.rest_s) begin(now_s);
        break;
    case Phase::ANSWER:
        break;
    }
    if (_phase != Phase::ANSWER || !_answer) return step;
    step.counted = std::exchange(_answer, std::nullopt);
    step.answer_s = now_s - _lineBegin_s;
    step.line_s = _line_s;
    go(Phase::RESTING, now_s);
    return step;
}

} // namespace midair::samples
