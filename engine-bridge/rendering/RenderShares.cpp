#include "engine-bridge/rendering/RenderShares.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Range.h"

#include <algorithm>
#include <cmath>

namespace midair::bridge
{

namespace
{

/// At both ends of a fade; below it nothing is played. A thousandth of the power can't be felt, but
/// its relative errors would be reported as thousands of percent.
constexpr double kFaint = 0.02;

double amplitudeOf(double whole)
{
    return whole < kFaint ? 0.0 : whole >= 1.0 ? 1.0 : std::sin(0.5 * base::kPi * whole);
}

/// sqrt(1 - amplitudeOf(whole)^2), and 0 for contacts that are equally faint.
double restOf(double whole)
{
    return whole < kFaint ? 1.0 : whole > 1.0 - kFaint ? 0.0 : std::cos(0.5 * base::kPi * whole);
}

} // namespace

bool RenderSharesOptions::isValid(std::string* error) const
{
    if (render == Render::INHERIT)
    {
        if (error)
            *error = "RenderSharesOptions: render is INHERIT, but there is nothing to inherit from";
        return false;
    }
    return base::RangeCheck("RenderSharesOptions: ")
        .within("trackerError_m", trackerError_m, 0.0, 0.1)
        .within("fade_s", fade_s, 0.0, 10.0)
        .within("hold_s", hold_s, 0.0, 10.0)
        .within("hysteresis", hysteresis, 1.0, 10.0)
        .within("spot_m", spot_m, 0.0, 0.1)
        .passed(error);
}

RenderShares::RenderShares(const RenderSharesOptions& options) : _options(options)
{
    std::string error;
    if (!options.isValid(&error)) throw base::InputError(error);
}

Render RenderShares::renderOf(const HapticObject& object) const
{
    const Render own = object.properties.render;
    if (object.properties.sensation.isMeant) return Render::CONTACT; // never its whole surface
    return own == Render::INHERIT ? _options.render : own;
}

bool RenderShares::concerns(const std::vector<HapticObject>& objects) const
{
    return std::any_of(objects.begin(),
                       objects.end(),
                       [this](const HapticObject& object)
                       { return renderOf(object) != Render::OBJECT; });
}

bool RenderShares::isUncertain(const Contact& contact,
                               const std::vector<HandCapsule>& bones,
                               double rest_s,
                               bool wasUncertain) const
{
    const ContactPatch& patch = contact.path.patch();
    double predicted_m = 0.0;
    for (const HandCapsule& bone : bones)
        if (bone.hand == patch.hand &&
            std::find(patch.bones.begin(), patch.bones.end(), bone.bone) != patch.bones.end())
            predicted_m = std::max(predicted_m, bone.sigma_m);
    const double late_m = contact.speed_m_s * rest_s;
    const double error_m = Eigen::Vector3d(_options.trackerError_m, predicted_m, late_m).norm();
    const double radius_m =
        std::max({std::sqrt(patch.semiMajor_m * patch.semiMinor_m),
                  std::sqrt(contact.path.semiMajor_m() * contact.path.semiMinor_m())});
    const double middle = std::sqrt(_options.hysteresis);
    const double allowed_m = (radius_m + _options.spot_m) * (wasUncertain ? 1.0 / middle : middle);
    return !(error_m <= allowed_m); // errors that aren't finite count as uncertain
}

void RenderShares::update(const std::vector<HapticObject>& objects,
                          const std::vector<Contact>& contacts,
                          const HandFrame& hands,
                          double time_s,
                          double rest_s)
{
    ++_updates;
    const std::vector<HandCapsule> bones = handCapsules(hands);
    if (!bones.empty())
    {
        _handsSeen_s = time_s;
        _wereHandsSeen = true;
    }
    const bool isKnown = _wereHandsSeen && time_s - _handsSeen_s <= _options.hold_s;
    for (const HapticObject& object : objects)
    {
        const Render render = renderOf(object);
        const auto found = _shares.find(object.touchId());
        const bool isNew = found == _shares.end();
        Share& share = isNew ? _shares[object.touchId()] : found->second;
        if (share.seen == _updates) continue; // another part of the same object
        share.seen = _updates;
        bool isUncertainNow = false;
        for (const Contact& contact : contacts)
            if (contact.path.patch().object == object.touchId() && contact.wanted_m > 0.0)
                isUncertainNow =
                    isUncertainNow || isUncertain(contact, bones, rest_s, share.isUncertain);
        share.isUncertain = isUncertainNow;
        share.wanted = render == Render::OBJECT     ? 1.0
                       : render == Render::CONTACT  ? 0.0
                       : isKnown && !isUncertainNow ? 0.0
                                                    : 1.0;
        // New objects, and objects that stop being AUTO, don't fade.
        if (isNew || render != Render::AUTO) share.whole = share.wanted;
    }
    for (auto share = _shares.begin(); share != _shares.end();)
        share = share->second.seen == _updates ? std::next(share) : _shares.erase(share);
}

void RenderShares::advance(double dt_s)
{
    const double most = _options.fade_s > 0.0 ? dt_s / _options.fade_s : 1.0;
    for (auto& [object, share] : _shares)
        share.whole += std::clamp(share.wanted - share.whole, -most, most);
}

void RenderShares::clear()
{
    _shares.clear();
    _wereHandsSeen = false;
}

double RenderShares::whole(std::uint64_t object) const
{
    const auto found = _shares.find(object);
    return found == _shares.end() ? 1.0 : amplitudeOf(found->second.whole);
}

double RenderShares::contacts(std::uint64_t object) const
{
    const auto found = _shares.find(object);
    return found == _shares.end() ? 0.0 : restOf(found->second.whole);
}

double RenderShares::mostWhole() const
{
    double most = 0.0;
    for (const auto& [object, share] : _shares)
        most = std::max(most, share.whole);
    return amplitudeOf(most);
}

bool RenderShares::isFading() const
{
    return std::any_of(_shares.begin(),
                       _shares.end(),
                       [](const auto& one) { return one.second.whole != one.second.wanted; });
}

} // namespace midair::bridge
