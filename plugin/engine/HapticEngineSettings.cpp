// How a HapticEngine makes what its player plays by: checks grants and ranges, and the caps of
// scenes inside it.

#include "device/limits/GuardedDevice.h"
#include "engine-bridge/scene/Convert.h"
#include "plugin/engine/HapticEngine.h"
#include "plugin/engine/Rehearsal.h"
#include "plugin/extending/ArrayConversion.h"
#include "plugin/settings/AllSettings.h"
#include "plugin/settings/EnvironmentVariables.h"
#include "plugin/settings/Grants.h"

#include <osgMidair/HapticScene>

#include <algorithm>

#include <fmt/format.h>

namespace osgMidair
{

using midair::base::Message;
using midair::base::MessageCode;

namespace
{

// As calibrate() allows it of a tracker (CalibrationOptions::scaleTolerance); told in
// HapticSettings.
constexpr double kCalibrationTolerance = 0.02;

/// Whether what is opened is a wish in both or in none, as its setting's row says, and asks for the
/// same beside the same file.
bool haveSameWishes(const HapticWishes& a, const HapticWishes& b)
{
    bool isAny = false;
    for (const Setting<HapticSettings>& row : sceneSettings().rows())
    {
        if (!row.isWish || !(row.effect & midair::base::Effect::REOPEN)) continue;
        const auto own = a.asked.find(row.name);
        const auto theirs = b.asked.find(row.name);
        const bool isOwn = own != a.asked.end();
        if (isOwn != (theirs != b.asked.end())) return false;
        if (isOwn && own->second != theirs->second) return false;
        isAny = isAny || isOwn;
    }
    return !isAny || a.folder == b.folder;
}

} // namespace

// The environment and the user's grants applied to the settings as they are given, without the
// user's caps; values that are out of range are repaired.
HapticSettings HapticEngine::granted(std::vector<Message>& messages) const
{
    std::vector<std::string> wrong;
    HapticSettings settings = Environment::replace(*_given.settings, wrong);
    settings = Grants::ofUser(messages).apply(settings, name(), messages);
    const std::vector<std::string> repaired = settings.repair();
    const std::vector<std::string>& why = settings.whySilenced;
    for (const std::vector<std::string>* all : {&std::as_const(wrong), &repaired})
        for (const std::string& what : *all)
            if (std::find(why.begin(), why.end(), what) == why.end())
                messages.push_back({MessageCode::SETTINGS_INVALID, what});
    return settings;
}

HapticSettings HapticEngine::grantedSettings() const
{
    if (!_settings.isRead) return *_given.settings;
    std::vector<Message> ignored; // they were said when the settings were read
    HapticSettings settings = Environment::restrict(granted(ignored));
    if (settings.isSilenced || _settings.isCrowded) settings.enabled = false;
    return settings;
}

// What is left of them where nothing real is opened, and of a limit that isn't understood, which
// disables the scene.
HapticSettings HapticEngine::usable(std::vector<Message>& messages)
{
    HapticSettings settings = granted(messages);
    _settings.isArrayRefused = std::any_of(messages.begin(),
                                           messages.end(),
                                           [](const Message& message)
                                           { return message.code == MessageCode::ARRAY_REFUSED; });
    if (_settings.isRehearsed)
        for (Message& message : rehearse(settings))
            messages.push_back(std::move(message));
    if (!settings.isSilenced) return settings;
    settings.enabled = false;
    for (const std::string& what : settings.whySilenced)
        messages.push_back({MessageCode::SETTINGS_SILENCED, what});
    if (settings.whySilenced.empty())
        messages.push_back(
            {MessageCode::SETTINGS_SILENCED, "isSilenced is set; nothing is played"});
    return settings;
}

// What is compared is as given: granted and repaired is the same for both, as the grants are.
bool HapticEngine::suits(const HapticEngine& other) const
{
    const osg::ref_ptr<osg::Node> alive = root(); // and with it the settings
    if (!alive || !_given.settings->enabled || isRehearsed() != other.isRehearsed()) return false;
    const HapticSettings& a = *_given.settings;
    const HapticSettings& b = *other._given.settings;
    if (sceneSettings().effects(a, b) & (midair::base::Effect::REOPEN | midair::base::Effect::MOVE))
        return false;
    return a.arrayDescription == b.arrayDescription && haveSameWishes(a.wishes, b.wishes) &&
           _ownership.owner.outer().empty();
}

void HapticEngine::setJoined(bool joined)
{
    _ownership.joined.setJoined(joined);
    if (joined && _followed.viewer) _ownership.joined.follow(*_followed.viewer);
}

void HapticEngine::setRehearsed(bool rehearsed)
{
    _settings.isRehearsed = rehearsed;
    _settings.isRead = false;
    lookNext();
}

std::vector<FoundObject> HapticEngine::found() const
{
    return mayPlay() ? _collector.found() : std::vector<FoundObject>();
}

// A disabled scene opens no new hand source, but keeps an open one, as it may be enabled again
// soon.
void HapticEngine::openHands(const HapticSettings& settings)
{
    const bool isOpen =
        !_settings.isBaked && (mayPlay() || settings.hands == _player.hands().named());
    const std::string error = _player.openHands(isOpen ? settings.hands : "");
    if (!error.empty()) say({MessageCode::HANDS_OPEN, error});
}

midair::bridge::PlayedOn HapticEngine::playedOn(const HapticSettings& settings) const
{
    midair::bridge::PlayedOn on;
    on.array = settings.array;
    on.described = settings.arrayDescription;
    if (settings.arrayDescription)
        on.make = [described = settings.arrayDescription] { return arrayOf(*described); };
    on.isRefused = _settings.isArrayRefused;
    on.device = settings.device;
    return on;
}

void HapticEngine::configure(const HapticSettings& given)
{
    if (_settings.isRead && given == _settings.seen)
    {
        _player.refresh();
        return;
    }
    _settings.seen = given;
    std::vector<Message> messages;
    auto used = std::make_shared<HapticSettings>(usable(messages));
    for (Message& message : messages)
        say(std::move(message));
    midair::bridge::PoseAndStretch parts;
    if (!midair::bridge::decompose(midair::bridge::toEigen(used->calibration), parts) ||
        !parts.stretch.isIdentity(kCalibrationTolerance))
    {
        say({MessageCode::SETTINGS_CALIBRATION,
             "calibration is not rigid (a scene unit is set by metresPerUnit); nothing is "
             "played"});
        parts = {};
        used->enabled = false;
    }
    if (!takePlace(used->enabled)) used->enabled = false;
    _settings.isReported = _settings.isReported || (given.enabled && !_settings.isBaked);
    _settings.used = used;
    _settings.isRead = true;
    _places.worldToArray = parts.pose;
    _places.toArray = parts.pose.matrix();
    _places.toArray.topLeftCorner<3, 3>() *= used->metresPerUnit;
    _collector.configure(_places.toArray, used->shadows);
    _player.configure(used, playedOn(*used), name());
    openHands(*used);
}

// A scene that plays has one of the process's places; one without opens nothing.
bool HapticEngine::takePlace(bool isEnabled)
{
    const bool isWanted = isEnabled && !_settings.isBaked;
    _settings.isCrowded = isWanted && !_ownership.place.take();
    if (!isWanted && _player.isClosed()) _ownership.place.leave();
    if (_settings.isCrowded)
        say({MessageCode::SCENE_LIMIT,
             fmt::format("{} is not played: {} scenes of this program play already, and no more do "
                         "at a time; put those that share an array into one HapticScene",
                         name(),
                         PlayingPlace::kMost)});
    return !_settings.isCrowded;
}

// Scenes inside this one may lower its limits, never raise them.
void HapticEngine::keepInnerLimits()
{
    midair::device::UserCaps limits;
    if (_collector.isSilenced()) limits.maxAmplitude = 0.0;
    for (const HapticScene* inner : _collector.innerScenes())
    {
        if (inner->getSettings().isSilenced)
        {
            say({MessageCode::SCENE_LIMIT,
                 "the HapticScene \"" + inner->getName() +
                     "\" was not understood: nothing is played"});
            for (const std::string& reason : inner->getSettings().whySilenced)
                say({MessageCode::SETTINGS_SILENCED, reason});
            limits.maxAmplitude = 0.0;
        }
        if (!HapticSettings::isLimit(
                inner->getMaxPressure(), inner->getMaxAmplitude(), inner->getEarLimit()))
        {
            say({MessageCode::SCENE_LIMIT,
                 "the HapticScene \"" + inner->getName() +
                     "\" has a cap that is out of range: nothing is played"});
            limits.maxAmplitude = 0.0;
            continue;
        }
        midair::device::UserCaps its;
        its.maxPressure_Pa = inner->getMaxPressure();
        its.maxAmplitude = inner->getMaxAmplitude();
        its.earLimit_dB = inner->getEarLimit();
        limits = midair::device::stricter(limits, its);
    }
    _player.setInnerLimits(limits);
}

} // namespace osgMidair
