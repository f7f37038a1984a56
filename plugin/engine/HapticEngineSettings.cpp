// How a HapticEngine applies settings: checks grants and ranges, and makes the pipeline that they
// describe.

#include "device/limits/GuardedDevice.h"
#include "engine-bridge/scene/Convert.h"
#include "haptics/base/AssignPart.h"
#include "haptics/base/InputError.h"
#include "haptics/sequence/FieldSettings.h"
#include "plugin/engine/HapticEngine.h"
#include "plugin/settings/EnvironmentVariables.h"
#include "plugin/settings/Grants.h"

#include <osgMidair/HapticScene>

#include <algorithm>

namespace osgMidair
{

namespace
{

/// Returns true if the change from one to the other needs no new pipeline. A scene that is disabled
/// is silent and keeps its device.
bool isForSameThread(HapticSettings a, const HapticSettings& b)
{
    a.enabled = b.enabled;
    a.hands = b.hands;
    a.wishes.hands = b.wishes.hands;
    a.reach = b.reach;
    a.shadows = b.shadows;
    return a == b;
}

} // namespace

// Applies the environment and the user's grants to the settings and repairs what is out of range. A
// limit that isn't understood disables the scene.
void HapticEngine::readSettings(const HapticSettings& given)
{
    std::vector<std::string> messages;
    _settings = Environment::apply(given, messages);
    _settings = Grants::ofUser(messages).apply(_settings, name(), messages);
    for (const std::string& what : _settings.repair())
        messages.push_back(what);
    if (_settings.isSilenced) _settings.enabled = false;
    for (const std::string& what : messages)
        say(what);
}

void HapticEngine::openHands()
{
    // A disabled scene opens no new hand source, but keeps an open one, as it may be enabled again
    // soon.
    const bool open = _settings.enabled || _settings.hands == _hands.uri();
    const std::string error =
        _hands.setSettings(open ? _settings.hands : "", _settings.reach, _settings.shadows);
    if (!error.empty()) say(error);
}

void HapticEngine::configure(const HapticSettings& given)
{
    if (_configured && given == _raw) return;
    _isStale = _isStale || !_configured || !isForSameThread(given, _raw);
    _configured = true;
    _raw = given;
    readSettings(given);

    midair::bridge::PoseAndStretch parts;
    if (!midair::bridge::decompose(midair::bridge::toEigen(_settings.calibration), parts) ||
        !parts.stretch.isIdentity(0.02))
    {
        say("calibration is not rigid (a scene unit is set by metresPerUnit); nothing is played");
        parts = {};
        _settings.enabled = false;
    }
    openHands();
    _worldToArray = parts.pose;
    _toArray = parts.pose.matrix();
    _toArray.topLeftCorner<3, 3>() *= _settings.metresPerUnit;
    _collector.configure(_toArray, _settings.shadows);
    if (_settings.enabled && _isStale) startThread();
}

// Scenes inside this one may lower its limits, never raise them.
void HapticEngine::keepInnerLimits()
{
    double pressure_Pa = 0.0;
    double amplitude = 1.0;
    for (const HapticScene* inner : _collector.innerScenes())
    {
        if (!HapticSettings::isLimit(inner->getMaxPressure(), inner->getMaxAmplitude()))
        {
            say("the HapticScene \"" + inner->getName() +
                "\" has a cap that is out of range: nothing is played");
            amplitude = 0.0;
            continue;
        }
        pressure_Pa = midair::device::stricterPressure(pressure_Pa, inner->getMaxPressure());
        amplitude = std::min(amplitude, inner->getMaxAmplitude());
    }
    if (pressure_Pa == _innerPressure_Pa && amplitude == _innerAmplitude) return;
    _innerPressure_Pa = pressure_Pa;
    _innerAmplitude = amplitude;
    if (_settings.enabled) startThread();
}

midair::bridge::HologramOptions HapticEngine::hologramOptions() const
{
    midair::bridge::HologramOptions options;
    options.owner = name();
    options.medium = midair::haptics::mediumOf(_settings);
    options.solver = _settings.solver;
    midair::base::assignPart<midair::haptics::SolverSettings>(options.solverOptions, _settings);
    midair::base::assignPart<midair::haptics::SequenceSettings>(options, _settings);
    midair::base::assignPart<midair::haptics::PlayingSettings>(options, _settings);
    options.deviceUri = _settings.device;
    options.maxPressure =
        midair::device::stricterPressure(_settings.maxPressure, _innerPressure_Pa);
    options.maxAmplitude = std::min(_settings.maxAmplitude, _innerAmplitude);
    return options;
}

// The hologram thread reads the array's file, so that no frame waits for it.
void HapticEngine::startThread()
{
    midair::bridge::HologramOptions options = hologramOptions();
    if (_filter) _filter(options);
    const midair::haptics::Medium medium = options.medium;
    _isStale = false;
    _submittedAny = false; // the new pipeline has got no snapshot yet
    const auto loaded = std::make_shared<LoadedArray>();
    auto make = [options = std::move(options), name = _settings.array, loaded]() mutable
    {
        try
        {
            if (name.empty()) throw midair::base::InputError("there is no array");
            options.array = midair::haptics::TransducerArray::load(name);
        }
        catch (const std::exception& error)
        {
            throw midair::base::InputError(std::string(error.what()) + "; nothing is played");
        }
        {
            const std::lock_guard<std::mutex> lock(loaded->mutex);
            loaded->array = std::make_shared<midair::haptics::TransducerArray>(options.array);
        }
        return std::make_unique<midair::bridge::HologramPipeline>(options);
    };
    const std::lock_guard<std::mutex> lock(_mutex);
    _array = loaded;
    _medium = medium;
    if (_thread)
        _thread->setPipeline(make);
    else
        _thread = std::make_unique<midair::bridge::HologramThread>(make);
}

} // namespace osgMidair
