#include "haptics/sensation/SensationPlayer.h"

#include "haptics/base/Units.h"
#include "haptics/sensation/SensationFigures.h"
#include "haptics/sensation/UniformDraw.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace midair::haptics
{

namespace
{

constexpr double kStepsPerMs = 20.0;
constexpr int kMostJumpsOfSample = 20000; // of one sample: those of a second
// Within these, no time in a pattern is infinite.
constexpr double kMostPatternSpeed = 1e6;
constexpr double kMostPlayed_ms = 1e12;

/// Returns the first step of the grid at or after \a time_ms that follows \a last_ms.
double stepAfter(double time_ms, double last_ms)
{
    constexpr double kRounding = 1e-6; // of a step
    return std::max(std::ceil(time_ms * kStepsPerMs - kRounding),
                    std::floor(last_ms * kStepsPerMs + kRounding) + 1.0) /
           kStepsPerMs;
}

} // namespace

SensationCarried SensationCarried::at(double rate_Hz)
{
    if (!(rate_Hz > 0.0)) return {};
    return {rate_Hz / SensationFigures::kLeastPoints, rate_Hz / SensationPlayer::kLeastOfPeriod};
}

SensationPlayer::SensationPlayer(std::shared_ptr<const Sensation> sensation,
                                 const SensationPlayerOptions& options) :
    _track(std::move(sensation)),
    _values(_track.sensation()),
    _options(options)
{
    restart();
}

void SensationPlayer::restart()
{
    _now = Progress();
    _now.modulation_turns = sensation().modulationStart;
    _shown_ms = 0.0;
}

void SensationPlayer::replace(std::shared_ptr<const Sensation> sensation)
{
    SensationValues values(*sensation);
    const std::vector<SensationParameter>& before = _track.sensation().parameters;
    for (std::size_t index = 0; index < before.size(); ++index)
        if (_values.isKnown(index)) values.set(before[index].name, _values[index]);
    _track = SensationTrack(std::move(sensation));
    _values = std::move(values);
}

void SensationPlayer::advance(double time_ms)
{
    double speed = _options.speed * sensation().speed.at(_values);
    _isBroken = !std::isfinite(speed);
    speed = _isBroken ? 0.0 : std::clamp(speed, -kMostPatternSpeed, kMostPatternSpeed);
    _speed = speed;
    double due_ms = std::numeric_limits<double>::infinity(); // keyframe whose jump follows
    int jumps = 0;
    while (_now.time_ms < time_ms)
    {
        const double reach_ms = _now.pattern_ms + speed * (time_ms - _now.time_ms);
        const auto jump = speed > 0.0 && jumps < kMostJumpsOfSample
                              ? _track.jump(_now.looked_ms, reach_ms, _values)
                              : std::nullopt;
        const double at_ms =
            jump ? stepAfter(_now.time_ms + (jump->at_ms - _now.pattern_ms) / speed, _now.time_ms)
                 : 0.0;
        if (jump && at_ms <= time_ms)
        {
            run(at_ms, speed);
            _now.pattern_ms = _now.looked_ms = jump->to_ms;
            ++jumps;
            continue;
        }
        run(time_ms, speed);
        if (jump)
            due_ms = jump->at_ms;
        else
            _now.looked_ms = _now.pattern_ms;
    }
    // What lies behind the keyframe of a due jump, perhaps a stop, isn't reached.
    _shown_ms = _now.pattern_ms < due_ms
                    ? _now.pattern_ms
                    : std::nextafter(due_ms, -std::numeric_limits<double>::infinity());
}

void SensationPlayer::run(double until_ms, double speed)
{
    while (_now.time_ms < until_ms)
    {
        const double passed_ms = until_ms - _now.time_ms;
        const double reach_ms = _now.pattern_ms + speed * passed_ms;
        const double next_ms = speed > 0.0   ? _track.nextKeyframe_ms(_now.pattern_ms)
                               : speed < 0.0 ? _track.previousKeyframe_ms(_now.pattern_ms)
                                             : std::numeric_limits<double>::infinity();
        // Between keyframes frequencies are linear, so that of the middle is their mean.
        const bool isKeyframeBefore = speed > 0.0 ? next_ms < reach_ms : next_ms > reach_ms;
        if (speed != 0.0 && isKeyframeBefore && std::isfinite(next_ms))
        {
            const double part_ms = std::min((next_ms - _now.pattern_ms) / speed, passed_ms);
            turn(part_ms, 0.5 * (_now.pattern_ms + next_ms));
            _now.time_ms += part_ms;
            _now.pattern_ms = next_ms;
            continue;
        }
        turn(passed_ms, 0.5 * (_now.pattern_ms + reach_ms));
        _now.time_ms = until_ms;
        _now.pattern_ms = reach_ms;
    }
}

void SensationPlayer::turn(double passed_ms, double middle_ms)
{
    const DrawnBrush brush = _track.brushAt(middle_ms, _values);
    const double draw = _now.draw_turns + 1e-3 * passed_ms * brush.draw_Hz;
    const double modulation = _now.modulation_turns + 1e-3 * passed_ms * brush.modulation_Hz;
    if (std::isfinite(draw)) _now.draw_turns = draw - std::floor(draw);
    if (std::isfinite(modulation)) _now.modulation_turns = modulation - std::floor(modulation);
}

TrackPoint SensationPlayer::pointNow() const
{
    const auto held = static_cast<std::uint64_t>(_now.time_ms / kHold_ms);
    TrackPoint point =
        _track.at(_shown_ms,
                  _values,
                  {uniformDraw(_options.seed, 2 * held), uniformDraw(_options.seed, 2 * held + 1)});
    if (_options.dropsHeight)
        point.position_mm.z() -= sensation().transform.translation_mm[2].at(_values);
    return point;
}

std::optional<SteadySensation> SensationPlayer::steady() const
{
    if (_isBroken || _speed < 0.0 || !_track.isSteady(_shown_ms, _speed > 0.0)) return std::nullopt;
    const TrackPoint point = pointNow();
    const DrawnBrush& brush = point.brush;
    const bool isFinite = point.position_mm.allFinite() && std::isfinite(point.intensity) &&
                          std::isfinite(brush.draw_Hz) && std::isfinite(brush.modulation_Hz) &&
                          brush.at(0.0).allFinite();
    if (point.isStopped || !isFinite) return std::nullopt;
    return SteadySensation{point.position_mm,
                           std::clamp(point.intensity, 0.0, 1.0),
                           brush,
                           _now.draw_turns,
                           _now.modulation_turns};
}

SensationSample SensationPlayer::sampleAt(double time_ms)
{
    if (std::isfinite(time_ms)) advance(std::min(time_ms, kMostPlayed_ms));
    const TrackPoint point = pointNow();

    SensationSample sample;
    sample.isOutline = point.brush.isDrawn() && std::abs(point.brush.draw_Hz) > _carried.draw_Hz;
    sample.isUnmodulated = std::abs(point.brush.modulation_Hz) > _carried.modulation_Hz;
    sample.position_mm = sample.path_mm = point.position_mm;
    if (!sample.isOutline)
        sample.position_mm.head<2>() += point.brush.at(base::kTwoPi * _now.draw_turns);
    const double wave =
        sample.isUnmodulated ? 1.0 : 0.5 + 0.5 * std::cos(base::kTwoPi * _now.modulation_turns);
    const double intensity = point.intensity * wave;
    sample.intensity = std::clamp(intensity, 0.0, 1.0);
    sample.isLimited = sample.intensity != intensity;
    sample.patternTime_ms = _shown_ms;
    sample.isStopped = point.isStopped;
    sample.isFinite = !_isBroken && sample.position_mm.allFinite() && std::isfinite(intensity) &&
                      std::isfinite(point.brush.draw_Hz) &&
                      std::isfinite(point.brush.modulation_Hz);
    sample.brush = point.brush;
    if (sample.isFinite) _place_mm = sample.position_mm;
    if (sample.isFinite && sample.isStopped) sample.intensity = 0.0;
    if (!sample.isFinite)
    {
        sample.position_mm = sample.path_mm = _place_mm;
        sample.intensity = 0.0;
        sample.isLimited = false;
    }
    return sample;
}

} // namespace midair::haptics
