#include "haptics/sensation/SensationEvaluator.h"

#include "haptics/base/Units.h"
#include "haptics/sensation/UniformDraw.h"

#include <Eigen/Geometry>

#include <cmath>

namespace midair::haptics
{

SensationSample SensationEvaluator::evaluate(double time_ms,
                                             const SensationValues& values,
                                             SensationState& state,
                                             const Eigen::Matrix4d& frame) const
{
    // A change of speed changes the offset, so the time in the pattern goes on without a jump.
    const double passed_ms = time_ms + state.offset_ms - state.last_ms;
    state.offset_ms += sensation().speed.at(values) * passed_ms - passed_ms;
    double pattern_ms = time_ms + state.offset_ms;
    if (const auto jump = _track.jump(state.last_ms, pattern_ms, values))
    {
        state.last_ms = jump->to_ms;
        state.offset_ms = jump->to_ms - time_ms;
        pattern_ms = time_ms + state.offset_ms;
    }
    else
        state.last_ms = pattern_ms;

    const TrackPoint point = _track.at(
        pattern_ms, values, {uniformDraw(_seed, state.draws), uniformDraw(_seed, state.draws + 1)});
    state.draws += 2;
    const Eigen::Vector4d path = frame * point.position_mm.homogeneous();
    const double time_s = 1e-3 * time_ms;
    const double angle_rad = std::fmod(time_s * point.brush.draw_Hz * base::kTwoPi, base::kTwoPi);

    SensationSample sample;
    sample.position_mm = path.head<3>() / path.w();
    sample.position_mm.head<2>() += point.brush.at(angle_rad);
    const double modulation_turns =
        point.brush.modulation_Hz * time_s + sensation().modulationStart;
    sample.intensity = point.intensity * (0.5 + 0.5 * std::cos(modulation_turns * base::kTwoPi));
    sample.patternTime_ms = pattern_ms;
    sample.isStopped = point.isStopped;
    sample.isFinite = sample.position_mm.allFinite() && std::isfinite(sample.intensity);
    sample.isLimited = sample.intensity < 0.0 || sample.intensity > 1.0;
    sample.brush = point.brush;
    return sample;
}

} // namespace midair::haptics
