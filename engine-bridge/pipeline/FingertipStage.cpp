#include "engine-bridge/pipeline/FingertipStage.h"

#include <memory>

namespace midair::bridge
{

namespace
{

// A point takes about 0.1 ms with 1000 transducers: a field that moves gets two more, a step of one
// that rests about a millisecond.
constexpr int kOfField = 2;
constexpr int kOfStep = 10;
// Foci move on with each field, a thousand a second. A figure of them that is this old is as good
// to read, and looking at each published field would take much of their processor time.
constexpr double kOfFoci_s = 0.1;

} // namespace

bool FingertipStage::hasTurn(bool isPlaying) const
{
    const auto isDue = [&](const PipelineStage& stage)
    { return stage.rest_s(isPlaying).value_or(1.0) <= 0.0; };
    return isPlaying && _search.hasWork() && !isDue(_refiner) && !isDue(_louder);
}

void FingertipStage::know(const haptics::FingertipForce& force)
{
    _known = force;
    _known.threshold_N = _context.options.feelThreshold;
}

// True if the last search was of foci, too, and not long ago.
bool FingertipStage::isKnown(const HologramResult& result) const
{
    const bool isPlayed = result.achieved_Pa.size() > 0 && result.achieved_Pa.maxCoeff() > 0.0f;
    return isPlayed && result.foci > 0 && _known.force_N > 0.0 &&
           _context.clock.now_s() < _ofFociUntil_s;
}

void FingertipStage::report(HologramResult& result, bool isOtherField)
{
    if (!isOtherField) return;
    const haptics::PlayedAs asContact = result.fingertip.how; // as ContactStage plays its foci
    if (isKnown(result) || result.sequence.fields == _fields)
        know(_known); // the threshold may be another one
    else
    {
        _ofFociUntil_s = result.foci > 0 ? _context.clock.now_s() + kOfFoci_s : 0.0;
        _fields = result.sequence.fields;
        know(_search.begin(result.points,
                           result.achieved_Pa.cast<double>(),
                           *result.array,
                           result.medium,
                           result.sequence,
                           result.foci > 0,
                           kOfField));
    }
    result.fingertip = _known;
    if (result.foci > 0) result.fingertip.how = asContact;
}

RestStep FingertipStage::attend(bool isPlaying)
{
    RestStep step;
    const HologramResult& last = *_context.last;
    if (!hasTurn(isPlaying)) return step;
    if (last.sequence.fields != _fields)
    {
        _search.end();
        return step;
    }
    know(
        _search.goOn(last.points, *last.array, last.medium, last.sequence, last.foci > 0, kOfStep));
    if (_search.hasWork() || _known.force_N == last.fingertip.force_N) return step;
    step.result = std::make_shared<HologramResult>(last);
    return step;
}

std::optional<double> FingertipStage::rest_s(bool isPlaying) const
{
    if (!hasTurn(isPlaying)) return std::nullopt;
    return 0.0;
}

} // namespace midair::bridge
