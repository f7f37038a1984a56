// How a HapticEngine applies settings: checks grants and ranges, and makes the pipeline that they
// describe.

#include "device/limits/GuardedDevice.h"
#include "device/opening/MultiDevice.h"
#include "engine-bridge/extending/OwnSolver.h"
#include "engine-bridge/rendering/ContactSettings.h"
#include "engine-bridge/scene/Convert.h"
#include "haptics/array/ArrayFileWatch.h"
#include "haptics/base/AssignPart.h"
#include "haptics/base/InputError.h"
#include "haptics/base/text/CodedError.h"
#include "haptics/base/text/Quantity.h"
#include "haptics/base/threads/SteadyClock.h"
#include "haptics/sequence/FieldSettings.h"
#include "plugin/engine/HapticEngine.h"
#include "plugin/engine/Rehearsal.h"
#include "plugin/extending/ArrayConversion.h"
#include "plugin/hands/MouseSource.h"
#include "plugin/scene/PropertyConversion.h"
#include "plugin/settings/Assignments.h"
#include "plugin/settings/EnvironmentVariables.h"
#include "plugin/settings/Grants.h"

#include <osgMidair/HapticScene>

#include <algorithm>
#include <array>

namespace osgMidair
{

using midair::base::InputError;
using midair::base::Message;
using midair::base::MessageCode;

namespace
{

// As calibrate() allows it of a tracker (CalibrationOptions::scaleTolerance); told in
// HapticSettings.
constexpr double kCalibrationTolerance = 0.02;

/// Returns true if the fields of both are played alike. The other settings are the engine's own.
bool playsAlike(HapticSettings a, const HapticSettings& b)
{
    a.enabled = b.enabled;
    a.array = b.array;
    a.arrayDescription = b.arrayDescription;
    a.dead = b.dead;
    a.weak = b.weak;
    a.device = b.device;
    a.calibration = b.calibration;
    a.metresPerUnit = b.metresPerUnit;
    a.hands = b.hands;
    a.reach = b.reach;
    a.shadows = b.shadows;
    a.prediction = b.prediction;
    a.trackerDelay = b.trackerDelay;
    a.temperatureSource = b.temperatureSource; // followThermometer() sets the temperature
    a.wishes = b.wishes;
    a.isSilenced = b.isSilenced;
    a.whySilenced = b.whySilenced;
    a.earCamera = b.earCamera;
    return a == b;
}

/// What is told when the array's file has changed.
std::string readAgain(const midair::haptics::TransducerArray& array)
{
    return "array \"" + array.name + "\" has changed and was read again: " +
           std::to_string(array.size() - static_cast<int>(array.dead.size())) + " of " +
           std::to_string(array.size()) + " transducers are driven";
}

} // namespace

// Applies the environment and the user's grants to the settings and repairs what is out of range. A
// limit that isn't understood disables the scene.
void HapticEngine::readSettings(const HapticSettings& given)
{
    std::vector<std::string> wrong;
    _settings = Environment::apply(given, wrong);
    const bool hadArray = !_settings.array.empty();
    std::vector<Message> messages;
    _settings = Grants::ofUser(messages).apply(_settings, name(), messages);
    _isArrayRefused = hadArray && _settings.array.empty();
    for (Message& message : messages)
        say(std::move(message));
    const std::vector<std::string> repaired = _settings.repair();
    const std::vector<std::string>& why = _settings.whySilenced;
    for (const std::vector<std::string>* all : {&std::as_const(wrong), &repaired})
        for (const std::string& what : *all)
            if (std::find(why.begin(), why.end(), what) == why.end())
                say({MessageCode::SETTINGS_INVALID, what});
    _granted = _settings;
    if (_isRehearsed)
        for (Message& message : rehearse(_settings))
            say(std::move(message));
    if (!_settings.isSilenced) return;
    _settings.enabled = _granted.enabled = false;
    for (const std::string& what : why)
        say({MessageCode::SETTINGS_SILENCED, what});
    if (why.empty()) say({MessageCode::SETTINGS_SILENCED, "isSilenced is set; nothing is played"});
}

// What is compared is as given: granted and repaired is the same for both, as the grants are.
bool HapticEngine::suits(const HapticEngine& other) const
{
    const osg::ref_ptr<osg::Node> alive = root(); // and with it the settings
    if (!alive || !_given->enabled || _isRehearsed != other._isRehearsed) return false;
    const HapticSettings& a = *_given;
    const HapticSettings& b = *other._given;
    return a.array == b.array && a.device == b.device && a.dead == b.dead && a.weak == b.weak &&
           a.arrayDescription == b.arrayDescription && a.calibration == b.calibration &&
           a.metresPerUnit == b.metresPerUnit && a.wishes.array == b.wishes.array &&
           a.wishes.device == b.wishes.device &&
           (!(a.wishes.array || a.wishes.device) || a.wishes.folder == b.wishes.folder) &&
           _owner.outer().empty();
}

void HapticEngine::setJoined(bool joined)
{
    _joined.setJoined(joined);
    if (joined && _viewer) _joined.follow(*_viewer);
}

void HapticEngine::setRehearsed(bool rehearsed)
{
    _isRehearsed = rehearsed;
    _configured = false; // the settings are read again
    lookNext();
}

std::vector<FoundObject> HapticEngine::found() const
{
    return _settings.enabled ? _collector.found() : std::vector<FoundObject>();
}

void HapticEngine::openHands()
{
    // A disabled scene opens no new hand source, but keeps an open one, as it may be enabled again
    // soon.
    const bool open = !_isBaked && (_settings.enabled || _settings.hands == _hands.uri());
    const std::string error =
        _hands.setSettings(open ? _settings.hands : "", _settings.reach, _settings.shadows);
    if (!error.empty()) say({MessageCode::HANDS_OPEN, error});
    static_assert(static_cast<int>(midair::bridge::PredictionMethod::ONE_EURO) ==
                  HapticSettings::ONE_EURO);
    _hands.setPrediction(static_cast<midair::bridge::PredictionMethod>(_settings.prediction),
                         _settings.trackerDelay);
}

// The hand begins in the middle of the workspace.
void HapticEngine::attachMouse()
{
    auto* mouse = dynamic_cast<MouseSource*>(_hands.active());
    if (!mouse || !_view.valid()) return;
    const Eigen::Vector3d middle = _toArray.inverse().topRightCorner<3, 1>();
    mouse->attach(*_view, _settings.metresPerUnit, midair::bridge::toOsg(middle));
}

// The camera's frame is the scene's world in its units, as that of the hands is.
void HapticEngine::listenAtCamera()
{
    constexpr double kEar_m = 0.08;
    _snapshot.ears.resize(3, 0);
    const osg::Camera* camera = _view.valid() ? _view->getCamera() : nullptr;
    if (!_settings.earCamera || !camera) return;
    const osg::Matrixd toWorld = camera->getInverseViewMatrix();
    const Eigen::Affine3d toArray(_toArray);
    const Eigen::Vector3d eye = toArray * midair::bridge::toEigen(toWorld.getTrans());
    const osg::Vec3d right(toWorld(0, 0), toWorld(0, 1), toWorld(0, 2));
    const Eigen::Vector3d aside =
        kEar_m * (toArray.linear() * midair::bridge::toEigen(right)).stableNormalized();
    _snapshot.ears.resize(3, 2);
    _snapshot.ears << eye - aside, eye + aside;
}

void HapticEngine::configure(const HapticSettings& given)
{
    // A program may set a variable at any time, and a cap holds from then on.
    midair::device::UserCaps caps = midair::device::capsOfUser();
    if (_configured && given == _raw && caps == _userCaps) return;
    _userCaps = std::move(caps);
    _configured = true;
    _raw = given;
    readSettings(given);

    midair::bridge::PoseAndStretch parts;
    if (!midair::bridge::decompose(midair::bridge::toEigen(_settings.calibration), parts) ||
        !parts.stretch.isIdentity(kCalibrationTolerance))
    {
        say({MessageCode::SETTINGS_CALIBRATION,
             "calibration is not rigid (a scene unit is set by metresPerUnit); nothing is "
             "played"});
        parts = {};
        _settings.enabled = false;
    }
    takePlace();
    _isReported = _isReported || (_raw.enabled && !_isBaked);
    openHands();
    _worldToArray = parts.pose;
    _toArray = parts.pose.matrix();
    _toArray.topLeftCorner<3, 3>() *= _settings.metresPerUnit;
    _collector.configure(_toArray, _settings.shadows);
    // A scene that is disabled opens nothing, but keeps a source that is open.
    _air.setSource(_settings.enabled || _settings.temperatureSource.empty()
                       ? _settings.temperatureSource
                       : _air.source());
    _air_C = _air.at(midair::base::steadySeconds(), _settings.temperature);
    applyToThread();
}

// Only the air changes: the device stays open, and the next field starts from the last one.
void HapticEngine::followThermometer()
{
    const double now_C = _air.at(midair::base::steadySeconds(), _settings.temperature);
    for (Message& message : _air.takeMessages())
        say(std::move(message));
    if (now_C == _air_C) return;
    _air_C = now_C;
    applyToThread();
}

// Scenes inside this one may lower its limits, never raise them.
void HapticEngine::keepInnerLimits()
{
    double pressure_Pa = 0.0;
    double amplitude = _collector.isSilenced() ? 0.0 : 1.0;
    double ears_dB = 0.0;
    for (const HapticScene* inner : _collector.innerScenes())
    {
        if (inner->getSettings().isSilenced)
        {
            say({MessageCode::SCENE_LIMIT,
                 "the HapticScene \"" + inner->getName() +
                     "\" was not understood: nothing is played"});
            for (const std::string& reason : inner->getSettings().whySilenced)
                say({MessageCode::SETTINGS_SILENCED, reason});
            amplitude = 0.0;
        }
        if (!HapticSettings::isLimit(
                inner->getMaxPressure(), inner->getMaxAmplitude(), inner->getEarLimit()))
        {
            say({MessageCode::SCENE_LIMIT,
                 "the HapticScene \"" + inner->getName() +
                     "\" has a cap that is out of range: nothing is played"});
            amplitude = 0.0;
            continue;
        }
        pressure_Pa = midair::device::stricterPressure(pressure_Pa, inner->getMaxPressure());
        amplitude = std::min(amplitude, inner->getMaxAmplitude());
        ears_dB = midair::device::stricterPressure(ears_dB, inner->getEarLimit());
    }
    if (pressure_Pa == _innerPressure_Pa && amplitude == _innerAmplitude &&
        ears_dB == _innerEarLimit_dB)
        return;
    _innerEarLimit_dB = ears_dB;
    _innerPressure_Pa = pressure_Pa;
    _innerAmplitude = amplitude;
    applyToThread();
}

midair::bridge::HologramOptions HapticEngine::hologramOptions() const
{
    midair::bridge::HologramOptions options;
    options.owner = name();
    options.medium = midair::haptics::mediumOf(_applied);
    options.solver = _applied.solver;
    midair::base::assignPart<midair::haptics::SolverSettings>(options.solverOptions, _applied);
    midair::base::assignPart<midair::haptics::SequenceSettings>(options, _applied);
    midair::base::assignPart<midair::haptics::PlayingSettings>(options, _applied);
    std::vector<std::array<double, 3>> places;
    midair::base::parsePlaces(_applied.earPoints, places); // judged by repair()
    options.contacts = midair::bridge::contactsOf(_applied, renderOf(_applied.render));
    options.earPoints.resize(3, static_cast<Eigen::Index>(places.size()));
    for (std::size_t l = 0; l < places.size(); ++l)
        options.earPoints.col(static_cast<Eigen::Index>(l)) =
            Eigen::Map<const Eigen::Vector3d>(places[l].data());
    options.solverFactory = midair::bridge::makeAnySolver;
    options.deviceUri = _applied.device;
    return options;
}

// Only another array or device is opened anew; all else acts on what is open. What changes while
// the scene is disabled waits, as nothing is played then.
void HapticEngine::applyToThread()
{
    if (!_settings.enabled) return;
    HapticSettings wanted = _settings;
    wanted.temperature = _air_C;
    wanted.maxPressure = midair::device::stricterPressure(_settings.maxPressure, _innerPressure_Pa);
    wanted.maxAmplitude = std::min(_settings.maxAmplitude, _innerAmplitude);
    wanted.earLimit = midair::device::stricterPressure(_settings.earLimit, _innerEarLimit_dB);
    const bool isOpen = _isOpen && wanted.array == _applied.array &&
                        wanted.device == _applied.device && wanted.dead == _applied.dead &&
                        wanted.weak == _applied.weak &&
                        wanted.arrayDescription == _applied.arrayDescription;
    const bool isSame = isOpen && playsAlike(wanted, _applied);
    _applied = std::move(wanted);
    if (_isBaked) return noteForBaking(isSame);
    if (!isOpen) return startThread();
    if (isSame) return;
    midair::bridge::HologramOptions options = hologramOptions();
    if (_filter) _filter(options);
    _submittedAny = false; // so that the next snapshot follows at once
    const std::lock_guard<std::mutex> lock(_mutex);
    _medium = options.medium;
    auto make = pipelineMaker(options);
    _thread->setOptions(std::move(options), std::move(make));
}

void HapticEngine::startThread()
{
    midair::bridge::HologramOptions options = hologramOptions();
    if (_filter) _filter(options);
    _isOpen = true;
    if (!_begun || options.deviceUri != _begunOn)
        _begun = std::make_shared<std::atomic<bool>>(false);
    _begunOn = options.deviceUri;
    _submittedAny = false; // the new pipeline has got no snapshot yet
    const auto watch = std::make_shared<midair::haptics::ArrayFileWatch>("");
    const auto isStale = [watch] { return watch->isChanged(midair::base::steadySeconds()); };
    const std::lock_guard<std::mutex> lock(_mutex);
    _array = std::make_shared<LoadedArray>();
    _watch = watch;
    _medium = options.medium;
    auto make = pipelineMaker(options);
    if (_thread)
        _thread->setPipeline(std::move(make), isStale);
    else
        _thread = std::make_unique<midair::bridge::HologramThread>(std::move(make), isStale);
    _thread->setMuted(_muted);
}

// The hologram thread reads the array's file, so that no frame waits for it.
std::function<std::unique_ptr<midair::bridge::HologramPipeline>()>
HapticEngine::pipelineMaker(const midair::bridge::HologramOptions& options) const
{
    return [options = midair::bridge::HologramOptions(options),
            name = _applied.array,
            described = _applied.arrayDescription,
            dead = _applied.dead,
            weak = _applied.weak,
            isRefused = _isArrayRefused,
            loaded = _array,
            watch = _watch,
            begun = _begun]() mutable
    {
        // Also after it could not be read; a setting may ask for a new pipeline, too.
        const bool isAnother = watch->wasChanged();
        try
        {
            if (name.empty() && !described) throw InputError("there is no array");
            *watch = midair::haptics::ArrayFileWatch(name);
            options.array =
                name.empty() ? arrayOf(*described) : midair::haptics::TransducerArray::load(name);
            options.array.mark(dead, weak);
        }
        catch (const std::exception& error)
        {
            // Of one code there is one message: the grants' own stays.
            throw midair::base::CodedError(isRefused ? MessageCode::ARRAY_REFUSED
                                                     : MessageCode::ARRAY_INVALID,
                                           std::string(error.what()) + "; nothing is played");
        }
        {
            const std::lock_guard<std::mutex> lock(loaded->mutex);
            if (isAnother)
            {
                options.notes = {{MessageCode::ARRAY_READ_AGAIN, readAgain(options.array)}};
                options.notes[0].count = ++loaded->rereads;
            }
            loaded->array = std::make_shared<midair::haptics::TransducerArray>(options.array);
        }
        // Another pipeline of this scene on the same device: its recording isn't begun anew.
        if (begun && *begun)
            options.deviceUri = midair::device::continuedRecordings(options.deviceUri);
        auto pipeline = std::make_unique<midair::bridge::HologramPipeline>(options);
        if (begun) *begun = true;
        return pipeline;
    };
}

} // namespace osgMidair
