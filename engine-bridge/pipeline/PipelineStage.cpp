#include "engine-bridge/pipeline/PipelineStage.h"

#include <vector>

namespace midair::bridge
{

// Array and air change only with the options and the reflectors.
void EarStage::setOptions()
{
    const HologramOptions& options = _context.options;
    _watch.setPlace(*_context.array, options.medium, options.earPoints);
    _watch.setLimit(options.earLimit);
}

bool EarStage::arrive(const SceneSnapshot*& snapshot)
{
    _isMoved = false;
    if (_watch.isUnmoved(snapshot->ears)) return true;
    _watch.setEars(snapshot->ears);
    _isMoved = limit_dB() > 0.0 && !(_keeps && _keeps());
    const HologramResult* last = _context.last.get();
    if (!_isMoved && last && last->state == ArrayState::PLAYING)
        _watch.play(last->sequence.fields, _context.clock.now_s());
    return !_isMoved;
}

void EarStage::report(HologramResult& result, bool isOtherField)
{
    const double now_s = _context.clock.now_s();
    const bool sounds = result.state == ArrayState::PLAYING;
    if (isOtherField || !_context.last || result.state != _context.last->state)
        _watch.play(sounds ? result.sequence.fields : std::vector<Eigen::VectorXcf>(), now_s);
    result.exposure = _watch.reading(now_s);
}

haptics::ExposureFigures EarStage::reading() const
{
    return _watch.reading(_context.clock.now_s());
}

} // namespace midair::bridge
