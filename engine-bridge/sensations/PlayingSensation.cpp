#include "engine-bridge/sensations/PlayingSensation.h"

#include "engine-bridge/hands/SegmentDistance.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;
using Attach = SensationProperties::Attach;
using Trigger = SensationProperties::Trigger;

constexpr double kNear_m = 0.1; // hands farther away have the proximity 0
constexpr std::size_t kMostTrail = 512;

haptics::SensationPlayerOptions playerOptions(const SensationProperties& sensation)
{
    haptics::SensationPlayerOptions options;
    options.speed = sensation.speed;
    options.seed = static_cast<std::uint64_t>(sensation.seed);
    // An attachment replaces the height above the array, as in AdapTics' engine.
    options.dropsHeight = sensation.attach != Attach::PLACE;
    return options;
}

/// Returns 1 for a hand that touches, 0 for one kNear_m away or none: by the distance to the
/// surface, without one to \a place.
double proximityOf(const HandFrame& hands,
                   const MeshDistance* surface,
                   const Eigen::Isometry3d& pose,
                   const Vector3d& place)
{
    double nearest_m = kNear_m;
    const Eigen::Isometry3d toMesh = pose.inverse();
    for (const HandCapsule& bone : handCapsules(hands))
        if (surface)
        {
            const NearestSpot spot = surface->nearest(moved(bone.shape, toMesh), nearest_m);
            if (spot.triangle >= 0) nearest_m = std::min(nearest_m, spot.distance_m);
        }
        else
            nearest_m = std::min(nearest_m,
                                 pointSegmentDistance(place, bone.shape.a, bone.shape.b) -
                                     bone.shape.radius_m);
    return 1.0 - std::clamp(nearest_m, 0.0, kNear_m) / kNear_m;
}

} // namespace

PlayingSensation::PlayingSensation(const HapticObject& object, std::uint64_t contact, int plays) :
    _object(object.touchId()),
    _contact(contact),
    _seed(object.properties.sensation.seed),
    _properties(object.properties),
    _player(object.properties.sensation.pattern, playerOptions(object.properties.sensation)),
    _plays(plays)
{
}

bool PlayingSensation::isOther(const HapticObject& object) const
{
    const SensationProperties& other = object.properties.sensation;
    return other.seed != _seed ||
           (other.attach == Attach::PLACE) != (_properties.sensation.attach == Attach::PLACE);
}

const Contact* PlayingSensation::touching(const std::vector<Contact>& contacts) const
{
    const Contact* deepest = nullptr;
    for (const Contact& one : contacts)
        if (one.path.patch().object == _object && one.wanted_m > 0.0 &&
            (!deepest || one.wanted_m > deepest->wanted_m))
            deepest = &one;
    return deepest;
}

void PlayingSensation::update(const HapticObject& object, const SensationSurroundings& around)
{
    const SensationProperties& wanted = object.properties.sensation;
    if (wanted.pattern != _properties.sensation.pattern) _player.replace(wanted.pattern);
    // Those that are no longer set have the pattern's own values again.
    if (wanted.parameters != _properties.sensation.parameters)
        _player.values() = haptics::SensationValues(*wanted.pattern);
    _player.setSpeed(wanted.speed);
    _properties = object.properties;
    const Contact* touch = touching(around.contacts);
    trigger(touch != nullptr);
    place(object, around, touch);
    setValues(object, around, touch);
    _tracking.framed_s = around.time_s;
    _tracking.isStale = false;
}

void PlayingSensation::begin()
{
    _player.restart();
    _begun_s.reset();
    _isWanted = true;
    _gain = 0.0;
    _sample = {};
    _limited = {};
}

void PlayingSensation::trigger(bool isTouched)
{
    const bool wasTouched = std::exchange(_tracking.wasTouched, isTouched);
    const int plays = std::exchange(_plays, _properties.sensation.plays);
    switch (_properties.sensation.trigger)
    {
    case Trigger::ALWAYS:
        if (!_isWanted) begin();
        break;
    case Trigger::PROGRAM:
        if (plays != _plays && _plays > 0) begin();
        if (_plays == 0) _isWanted = false;
        break;
    case Trigger::TOUCH_BEGIN:
        if (isTouched && !wasTouched) begin();
        break;
    case Trigger::TOUCH_STAY:
        if (isTouched && !wasTouched) begin();
        if (!isTouched) _isWanted = false;
        break;
    case Trigger::TOUCH_END:
        if (!isTouched && wasTouched) begin();
        break;
    }
}

// A touch that has ended leaves its frame, so that the sensation fades out where it was.
void PlayingSensation::place(const HapticObject& object,
                             const SensationSurroundings& around,
                             const Contact* touch)
{
    std::optional<SensationFrame> frame;
    switch (_properties.sensation.attach)
    {
    case Attach::PLACE:
        frame.emplace();
        frame->toArray = object.pose;
        break;
    case Attach::SURFACE:
        if (touch)
            frame = frameOnSurface(touch->path.patch());
        else if (_properties.sensation.needsHands())
            frame = _tracking.isKnown ? std::optional<SensationFrame>(_frame) : std::nullopt;
        else if (around.surface || !object.mesh || object.mesh->triangles.cols() == 0)
            frame = frameUnderOrigin(object, around.surface);
        break;
    case Attach::HAND:
        if (touch) _tracking.hand = touch->path.patch().hand;
        frame = frameOfHand(around.hands, _properties.sensation.joint, _tracking.hand);
        break;
    }
    if (frame)
    {
        _frame = std::move(*frame);
        _tracking.isKnown = true;
        _tracking.seen_s = around.time_s;
    }
    else if (around.time_s - _tracking.seen_s > kLost_s)
    {
        _tracking.isKnown = false;
        _tracking.hand = -1;
        if (_properties.sensation.trigger != Trigger::ALWAYS) _isWanted = false;
    }
}

// The program's values come last.
void PlayingSensation::setValues(const HapticObject& object,
                                 const SensationSurroundings& around,
                                 const Contact* touch)
{
    constexpr double kMillimetres = 1e3;
    haptics::SensationValues& values = _player.values();
    const haptics::Sensation& pattern = _player.sensation();
    const auto knows = [&pattern](const char* name)
    { return pattern.parameterIndex(name) < pattern.parameters.size(); };
    if (knows("proximity"))
        values.set("proximity",
                   touch ? 1.0
                         : proximityOf(around.hands,
                                       around.surface.get(),
                                       object.pose,
                                       _frame.toArray.translation()));
    if (knows("depth")) values.set("depth", touch ? kMillimetres * touch->wanted_m : 0.0);
    if (knows("speed")) values.set("speed", touch ? touch->speed_m_s : 0.0);
    for (const auto& [name, value] : _properties.sensation.parameters)
        values.set(name, value);
}

bool PlayingSensation::mayPlay() const
{
    return _isWanted && _tracking.isKnown && !_tracking.isStale && !_sample.isStopped;
}

// Returns the time since the begin, without the time in which nothing was rendered.
double PlayingSensation::patternTime_ms(double now_s)
{
    if (!_begun_s) _begun_s = now_s;
    const double gap_s = now_s - _rendered_s;
    if (_rendered_s > *_begun_s && gap_s > kStale_s) _begun_s = *_begun_s + gap_s;
    _rendered_s = now_s;
    return 1e3 * (now_s - *_begun_s);
}

void PlayingSensation::noteLimits()
{
    if (!_sample.isFinite) _limited.isBroken = true;
    if (_sample.isLimited) _limited.isOutOfRange = true;
    if (_sample.isOutline && _limited.outline_Hz == 0.0)
        _limited.outline_Hz = _sample.brush.draw_Hz;
    if (_sample.isUnmodulated && _limited.modulation_Hz == 0.0)
        _limited.modulation_Hz = _sample.brush.modulation_Hz;
    // A faster device plays it as drawn.
    if (!_sample.isOutline) _limited.outline_Hz = 0.0;
    if (!_sample.isUnmodulated) _limited.modulation_Hz = 0.0;
}

Eigen::Vector3d PlayingSensation::middle() const
{
    return _frame.at(kPatternUnit_m * _sample.path_mm);
}

ContactFocus PlayingSensation::focus() const
{
    ContactFocus focus;
    focus.object = _object;
    focus.contact = _contact;
    focus.centre = _frame.toArray.translation();
    // Out of an object is into a hand.
    focus.normal =
        _properties.sensation.attach == Attach::HAND ? Vector3d(-_frame.normal()) : _frame.normal();
    return focus;
}

std::optional<SteadyPart> PlayingSensation::steady(double pressure_Pa) const
{
    if (!mayPlay() || _gain < 1.0 || !_sample.isFinite) return std::nullopt;
    const std::optional<haptics::SteadySensation> pattern = _player.steady();
    if (!pattern) return std::nullopt;
    SteadyPart part{*pattern, _frame, focus()};
    part.focus.pressure_Pa = pressure_Pa;
    return part;
}

void PlayingSensation::render(double now_s,
                              double dt_s,
                              double pressure_Pa,
                              const haptics::SensationCarried& carried,
                              std::vector<ContactFocus>& foci)
{
    if (!isPlaying()) return;
    _player.setCarried(carried);
    _sample = _player.sampleAt(patternTime_ms(now_s));
    if (_sample.isStopped && _properties.sensation.trigger == Trigger::ALWAYS && _isWanted)
    {
        begin();
        _sample = _player.sampleAt(patternTime_ms(now_s));
    }
    noteLimits();
    if (_sample.isStopped) _isWanted = false;
    _tracking.isStale = _properties.sensation.needsHands() && now_s - _tracking.framed_s > kStale_s;
    const double wanted = mayPlay() ? 1.0 : 0.0;
    _gain += std::clamp(wanted - _gain, -dt_s / kFadeOut_s, dt_s / kFadeIn_s);

    ContactFocus focus = this->focus();
    focus.pressure_Pa = pressure_Pa * intensity();
    if (_sample.isOutline)
        appendOutline(_frame, _sample.path_mm, _sample.brush, focus, foci);
    else
        appendFocus(_frame, _sample.position_mm, focus, foci);
    _trail.push_back({now_s, focus.position, intensity()});
    const double turn_s = _sample.brush.draw_Hz > 0.0 ? 1.0 / _sample.brush.draw_Hz : 0.0;
    const double kept_s = std::clamp(turn_s, SensationView::kTrail_s, 1.0);
    while (_trail.front().time_s < now_s - kept_s || _trail.size() > kMostTrail)
        _trail.pop_front();
}

SensationView PlayingSensation::view() const
{
    SensationView view;
    view.object = _object;
    view.isPlaying = isPlaying();
    view.isStopped = _sample.isStopped;
    view.patternTime_ms = _sample.patternTime_ms;
    view.intensity = isPlaying() ? intensity() : 0.0;
    view.place = _frame.at(kPatternUnit_m * _sample.position_mm);
    if (isPlaying()) view.trail.assign(_trail.begin(), _trail.end());
    return view;
}

} // namespace midair::bridge
