#include "haptics/sensation/SensationTrack.h"

#include "haptics/base/Units.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace midair::haptics
{

namespace
{

/// Shares of the values before and after.
struct Mix
{
    double before;
    double after;

    double of(double first, double second) const { return before * first + after * second; }
};

Mix mixAt(double time_ms, double before_ms, double after_ms, SensationTransition transition)
{
    const double t = (time_ms - before_ms) / (after_ms - before_ms);
    if (transition == SensationTransition::LINEAR) return {1.0 - t, t};
    return t < 1.0 ? Mix{1.0, 0.0} : Mix{0.0, 1.0};
}

bool holds(const SensationJump& jump, const SensationValues& values)
{
    if (!values.isKnown(jump.parameter)) return false;
    const double value = values[jump.parameter];
    switch (jump.comparison)
    {
    case SensationJump::Comparison::LESS:
        return value < jump.value;
    case SensationJump::Comparison::LESS_OR_EQUAL:
        return value <= jump.value;
    case SensationJump::Comparison::GREATER:
        return value > jump.value;
    case SensationJump::Comparison::GREATER_OR_EQUAL:
        break;
    }
    return value >= jump.value;
}

DrawnBrush drawn(const SensationBrush& brush, const SensationValues& values)
{
    DrawnBrush now;
    now.x_mm = brush.x_mm.at(values);
    now.draw_Hz = brush.draw_Hz.at(values);
    now.modulation_Hz = brush.modulation_Hz.at(values);
    now.phase_rad = 0.5 * base::kPi;
    if (brush.kind == SensationBrush::Kind::CIRCLE)
        now.y_mm = now.x_mm;
    else if (brush.kind == SensationBrush::Kind::LINE)
        now.rotation_rad = base::toRadians(brush.rotation.at(values));
    else
    {
        now.y_mm = brush.y_mm.at(values);
        now.a = brush.a.at(values);
        now.b = brush.b.at(values);
        now.phase_rad = brush.phase_rad.at(values);
        now.rotation_rad = brush.rotation.at(values);
    }
    return now;
}

double valueOf(const SensationIntensity& intensity, const SensationValues& values, double draw)
{
    const double low = intensity.low.at(values);
    return intensity.isRandom ? draw * (intensity.high.at(values) - low) + low : low;
}

} // namespace

SensationTrack::SensationTrack(std::shared_ptr<const Sensation> sensation) :
    _sensation(std::move(sensation)),
    _spans(_sensation->keyframes.size() + 1)
{
    const std::vector<SensationKeyframe>& frames = _sensation->keyframes;
    Keys keys;
    for (std::size_t i = 0; i < frames.size(); ++i)
    {
        _times_ms.push_back(frames[i].time_ms);
        if (!frames[i].jumps.empty()) _jumpers.push_back(i);
        meet(i, keys);
        _spans[i + 1].before = keys;
        _spans[i + 1].isStopped = frames[i].kind == SensationKeyframe::Kind::STOP;
    }
    keys = Keys();
    for (std::size_t i = frames.size(); i-- > 0;)
    {
        meet(i, keys);
        _spans[i].after = keys;
        _spans[i].isMoving = frames[i].kind == SensationKeyframe::Kind::STANDARD;
    }
}

void SensationTrack::meet(std::size_t index, Keys& keys) const
{
    const SensationKeyframe& next = _sensation->keyframes[index];
    const Key own = {static_cast<int>(index), next.time_ms};
    const bool isStop = next.kind == SensationKeyframe::Kind::STOP;
    if (next.kind == SensationKeyframe::Kind::STANDARD)
        keys.position = own;
    else
        keys.position.time_ms = own.time_ms;
    if (next.brush)
        keys.brush = own;
    else if (isStop)
        keys.brush.time_ms = own.time_ms;
    if (next.intensity)
        keys.intensity = own;
    else if (isStop)
        keys.intensity.time_ms = own.time_ms;
}

const SensationTrack::Span& SensationTrack::spanAt(double time_ms) const
{
    const auto next = std::upper_bound(_times_ms.begin(), _times_ms.end(), time_ms);
    return _spans[static_cast<std::size_t>(next - _times_ms.begin())];
}

TrackPoint SensationTrack::at(double time_ms,
                              const SensationValues& values,
                              const std::array<double, 2>& draws) const
{
    const Span& span = spanAt(time_ms);
    TrackPoint point;
    point.position_mm = transformed(positionIn(span, time_ms), values);
    point.intensity =
        _sensation->intensityFactor.at(values) * intensityIn(span, time_ms, values, draws);
    point.brush = brushIn(span, time_ms, values);
    point.isStopped = span.isStopped;
    return point;
}

DrawnBrush SensationTrack::brushAt(double time_ms, const SensationValues& values) const
{
    return brushIn(spanAt(time_ms), time_ms, values);
}

Eigen::Vector3d SensationTrack::positionIn(const Span& span, double time_ms) const
{
    const Key& before = span.before.position;
    const Key& after = span.after.position;
    if (before.index < 0) return Eigen::Vector3d::Zero();
    const SensationKeyframe& first = frame(before);
    if (after.index < 0 || !span.isMoving) return first.position_mm;
    const Mix mix = mixAt(time_ms, before.time_ms, after.time_ms, first.positionTransition);
    return mix.before * first.position_mm + mix.after * frame(after).position_mm;
}

Eigen::Vector3d SensationTrack::transformed(const Eigen::Vector3d& at,
                                            const SensationValues& values) const
{
    const SensationTransform& transform = _sensation->transform;
    const double x = at.x() * transform.scale[0].at(values);
    const double y = at.y() * transform.scale[1].at(values);
    const double z = at.z() * transform.scale[2].at(values);
    const double angle = base::toRadians(transform.rotation_deg.at(values));
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    return {x * c - y * s + transform.translation_mm[0].at(values),
            x * s + y * c + transform.translation_mm[1].at(values),
            z + transform.translation_mm[2].at(values)};
}

double SensationTrack::intensityIn(const Span& span,
                                   double time_ms,
                                   const SensationValues& values,
                                   const std::array<double, 2>& draws) const
{
    const Key& before = span.before.intensity;
    const Key& after = span.after.intensity;
    if (before.index < 0) return 0.0;
    const SensationKeyframe& first = frame(before);
    const double value = valueOf(*first.intensity, values, draws[0]);
    if (after.index < 0) return value;
    return mixAt(time_ms, before.time_ms, after.time_ms, first.intensityTransition)
        .of(value, valueOf(*frame(after).intensity, values, draws[1]));
}

DrawnBrush
SensationTrack::brushIn(const Span& span, double time_ms, const SensationValues& values) const
{
    const Key& before = span.before.brush;
    const Key& after = span.after.brush;
    if (before.index < 0) return {};
    const SensationKeyframe& first = frame(before);
    DrawnBrush now = drawn(*first.brush, values);
    if (after.index < 0 || frame(after).brush->kind != first.brush->kind) return now;
    const Mix mix = mixAt(time_ms, before.time_ms, after.time_ms, first.brushTransition);
    const DrawnBrush then = drawn(*frame(after).brush, values);
    now.rotation_rad = mix.of(now.rotation_rad, then.rotation_rad);
    now.modulation_Hz = mix.of(now.modulation_Hz, then.modulation_Hz);
    if (first.brush->kind == SensationBrush::Kind::LISSAJOUS) return now;
    now.x_mm = mix.of(now.x_mm, then.x_mm);
    now.y_mm = mix.of(now.y_mm, then.y_mm);
    return now;
}

bool SensationTrack::isSteady(double time_ms, bool passes) const
{
    const Keys& keys = spanAt(time_ms).before;
    const bool isLast = _times_ms.empty() || time_ms >= _times_ms.back();
    const auto isRandom = [this](const Key& key)
    { return key.index >= 0 && frame(key).intensity->isRandom; };
    if (passes) return isLast && !isRandom(keys.intensity);
    return !isRandom(keys.intensity) && !isRandom(spanAt(time_ms).after.intensity);
}

std::optional<TakenJump>
SensationTrack::jump(double after_ms, double until_ms, const SensationValues& values) const
{
    const auto first = std::upper_bound(_jumpers.begin(),
                                        _jumpers.end(),
                                        after_ms,
                                        [this](double time_ms, std::size_t index)
                                        { return time_ms < _times_ms[index]; });
    for (auto jumper = first; jumper != _jumpers.end() && _times_ms[*jumper] <= until_ms; ++jumper)
        for (const SensationJump& jump : _sensation->keyframes[*jumper].jumps)
            if (holds(jump, values)) return TakenJump{_times_ms[*jumper], jump.to_ms};
    return {};
}

double SensationTrack::nextKeyframe_ms(double time_ms) const
{
    const auto next = std::upper_bound(_times_ms.begin(), _times_ms.end(), time_ms);
    return next == _times_ms.end() ? std::numeric_limits<double>::infinity() : *next;
}

double SensationTrack::previousKeyframe_ms(double time_ms) const
{
    const auto next = std::lower_bound(_times_ms.begin(), _times_ms.end(), time_ms);
    return next == _times_ms.begin() ? -std::numeric_limits<double>::infinity() : *std::prev(next);
}

} // namespace midair::haptics
