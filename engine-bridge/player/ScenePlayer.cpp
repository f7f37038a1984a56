#include "engine-bridge/player/ScenePlayer.h"

#include "engine-bridge/player/SceneOptions.h"
#include "engine-bridge/playing/EarBound.h"
#include "engine-bridge/settings/SceneTable.h"
#include "haptics/base/settings/Setting.h"
#include "haptics/base/text/Quantity.h"
#include "haptics/base/text/Words.h"
#include "haptics/base/threads/SteadyClock.h"

#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

using base::MessageCode;

namespace
{

/// Pause before a field that the device refused is tried again.
constexpr double kRetry_s = 0.5;
/// A solver that takes longer for one field, while the scene moves on, is reported.
constexpr double kSlowSolve_s = 1.0;
/// A solver that hasn't been slow for this long is reported again the next time.
constexpr double kSlowOver_s = 5.0;
/// A field that can't be felt for as long is told.
constexpr double kFaint_s = 3.0;

PredictionMethod methodOf(SceneSettings::Prediction prediction)
{
    static_assert(static_cast<int>(PredictionMethod::ONE_EURO) == SceneSettings::ONE_EURO);
    return static_cast<PredictionMethod>(prediction);
}

/// Puts the figures of \a result into \a all.
void addFigures(const HologramResult& result, SceneStatistics& all)
{
    base::assignPart<haptics::FieldFigures>(all, result.report());
    all.fieldFrame = result.frame;
    all.points = result.points.size();
    all.maxPressure_Pa = result.maxPressure_Pa;
    const bool inTurn = result.sequence.fields.size() > 1;
    all.fieldsInTurn = inTurn ? static_cast<int>(result.sequence.fields.size()) : 0;
    all.fieldRate_Hz = inTurn ? result.sequence.modulation.fieldRate_Hz : 0.0;
    all.outline = result.outline;
    all.evened = result.sequence.evened && result.sequence.isHeld();
    if (result.monitored && result.monitored->certificate.points > 0)
        all.certifiedGap = result.monitored->certificate.gapOfPhases();
    all.figures = haptics::figuresOf(result.report());
    all.fingertipForce_N = result.fingertip.force_N;
    all.feeling = result.fingertip.feeling();
    all.figures.emplace_back("fingertipForce_N", all.fingertipForce_N);
    all.updatesPerSecond = result.updatesPerSecond;
    all.latency_ms = result.latency_ms;
    all.stop = haptics::stopReasonName(result.report().stop);
}

} // namespace

void SubmittedFrame::note(const SceneSnapshot& snapshot, double now_s)
{
    _felt.resize(snapshot.objects.size());
    bool isMoved = false;
    for (std::size_t i = 0; i < _felt.size(); ++i)
    {
        const HapticObject& object = snapshot.objects[i];
        isMoved =
            isMoved || (_felt[i].id == object.id && _felt[i].pose.matrix() != object.pose.matrix());
        _felt[i].id = object.id;
        _felt[i].meshId = object.meshId;
        _felt[i].properties = object.properties;
        _felt[i].clips = object.clips;
        _felt[i].pose = object.pose;
    }
    _around = snapshot.around;
    _reflectors = snapshot.reflectors;
    _bodies = snapshot.bodies;
    _ears = snapshot.ears;
    _at_s = now_s;
    _isAny = true;
    constexpr double kRests_s = 2.0 * ObjectMotion::kLongestGap_s;
    if (!isMoved) return;
    if (now_s - _moved_s <= ObjectMotion::kLongestGap_s) _movesUntil_s = now_s + kRests_s;
    _moved_s = now_s;
}

bool SubmittedFrame::isSame(const HapticObject& object, const Felt& felt)
{
    return object.id == felt.id && object.meshId == felt.meshId &&
           object.properties == felt.properties && object.clips == felt.clips &&
           object.pose.matrix() == felt.pose.matrix();
}

bool SubmittedFrame::differs(const SceneSnapshot& snapshot, bool objectsToo) const
{
    if (!_isAny || !equivalent(snapshot.around, _around) || !(snapshot.reflectors == _reflectors) ||
        !(snapshot.bodies == _bodies))
        return true;
    const Eigen::Matrix3Xd& ears = snapshot.ears;
    if (ears.cols() != _ears.cols() ||
        (ears.cols() > 0 &&
         !((ears - _ears).colwise().norm().maxCoeff() <= EarWatch::kTolerance_m)))
        return true;
    return objectsToo && !std::equal(snapshot.objects.begin(),
                                     snapshot.objects.end(),
                                     _felt.begin(),
                                     _felt.end(),
                                     isSame);
}

ScenePlayer::ScenePlayer(Host host) :
    _host(std::move(host)),
    _log(_host.print),
    _hands(_host.openHands),
    _heads(_host.openHead)
{
    _wanted.settings = _played.settings = std::make_shared<const SceneSettings>();
    _air.at(base::steadySeconds(), _wanted.settings->temperature);
}

ScenePlayer::~ScenePlayer() = default;

// --- Settings ------------------------------------------------------------------------------------

void ScenePlayer::configure(std::shared_ptr<const SceneSettings> settings,
                            const PlayedOn& on,
                            const std::string& owner)
{
    _wanted.settings = std::move(settings);
    _wanted.on = on;
    _wanted.owner = owner;
    judgeCaps();
    _hands.setPrediction(methodOf(_wanted.settings->prediction), _wanted.settings->trackerDelay);
    _heads.setPrediction(methodOf(_wanted.settings->prediction), _wanted.settings->trackerDelay);
    // A disabled scene opens nothing, but keeps a source that is already open.
    const std::string& source = _wanted.settings->temperatureSource;
    _air.setSource(mayPlay() || source.empty() ? source : _air.source());
    refresh();
    noteSilence();
}

SceneSettings ScenePlayer::playedSettings() const
{
    SceneSettings settings = restricted(*_wanted.settings, _wanted.limits);
    settings.temperature = _wanted.air_C;
    return settings;
}

void ScenePlayer::setInnerLimits(const device::UserCaps& limits)
{
    if (limits == _caps.inner) return;
    _caps.inner = limits;
    judgeCaps();
    apply();
}

void ScenePlayer::refresh()
{
    // Programs may set a variable at any time; the cap applies from then on.
    device::UserCaps user = device::capsOfUser();
    if (!(user == _caps.user))
    {
        _caps.user = std::move(user);
        judgeCaps();
    }
    _wanted.air_C = _air.at(base::steadySeconds(), _wanted.settings->temperature);
    apply();
}

// Each row checks its own places; together with the user's places they may be too many.
void ScenePlayer::judgeCaps()
{
    _wanted.limits = device::stricter(_caps.user, _caps.inner);
    std::vector<std::string> wrong = _wanted.limits.wrong;
    const std::string places =
        device::joinedPlaces(_wanted.settings->earPoints, _wanted.limits.earPoints);
    Eigen::Matrix3Xd read;
    if (!readPlaces(places, read))
        wrong.push_back("earPoints is \"" + places + "\", should be " + base::kPlacesExpected +
                        "; nothing is played");
    if (wrong == _caps.wrong) return;
    _caps.wrong = std::move(wrong);
    std::vector<base::Message> told;
    for (const std::string& why : _caps.wrong)
        told.emplace_back(MessageCode::SETTINGS_SILENCED, why);
    _log.sayNow({MessageCode::SETTINGS_SILENCED, 0, "caps"}, told);
}

std::string ScenePlayer::whySilenced() const
{
    if (!_caps.wrong.empty()) return _caps.wrong.front();
    return _caps.user.isSilencing ? device::kDisabledByUser : "";
}

HologramOptions ScenePlayer::options() const
{
    HologramOptions options =
        optionsOf(restricted(*_played.settings, _played.limits), _played.air_C);
    options.owner = _played.owner;
    options.isSilencedElsewhere = _played.limits.isSilencing;
    options.deviceUri = _played.on.device;
    return options;
}

// Only another array or device is opened again; all other changes act on the open pipeline. Changes
// wait while nothing may be played.
void ScenePlayer::apply()
{
    if (!mayPlay() || _wanted.on == PlayedOn()) return;
    const unsigned effects = sceneTable().effects(*_wanted.settings, *_played.settings);
    const bool isOpen =
        _opening.isOpen && _wanted.on == _played.on && !(effects & base::Effect::REOPEN);
    const bool isSame = isOpen && !(effects & base::Effect::SOLVE) &&
                        _wanted.limits == _played.limits && _wanted.air_C == _played.air_C;
    _played = _wanted;
    if (isSame) return;
    ++_opening.changes;
    _submitted.forget(); // so that the next snapshot is submitted at once
    if (!isOpen || _opening.isKeptClosed)
        _maker.begin(_played.on, _played.settings->dead, _played.settings->weak);
    HologramOptions made = options();
    {
        const base::Lock lock(_shared.mutex);
        _shared.medium = made.medium;
        _shared.counts.temperature_C = _played.air_C;
    }
    _opening.isOpen = true;
    if (_opening.isKeptClosed) return;
    if (_host.filter) _host.filter(made);
    if (!isOpen) return start(made);
    auto otherwise = _maker.factory(made);
    _opening.thread->setOptions(std::move(made), std::move(otherwise));
}

void ScenePlayer::start(const HologramOptions& options)
{
    auto make = _maker.factory(options);
    const base::Lock lock(_shared.mutex);
    if (_opening.thread)
        _opening.thread->setPipeline(std::move(make), _maker.staleCheck());
    else
        _opening.thread =
            std::make_unique<HologramThread>(std::move(make), _maker.staleCheck(), _shared.lead);
    _shared.thread = _opening.thread.get();
}

void ScenePlayer::keepClosed()
{
    if (!std::exchange(_opening.isKeptClosed, true)) _opening.isOpen = false;
}

// --- Frames --------------------------------------------------------------------------------------

void ScenePlayer::locateHands(const Eigen::Isometry3d& handsToArray)
{
    _hands.locate(_snapshot.simulationTime_s, handsToArray);
    _snapshot.around.reach_m = _wanted.settings->reach;
    _snapshot.around.shadows = _wanted.settings->shadows;
    _snapshot.around.hands = handCapsules(_hands.frame());
    _snapshot.hands = _hands.frame();
    _snapshot.handsLate_s = _hands.late_s();
    const bool isAny = !_snapshot.hands.hands.empty();
    if (isAny) _times.handsSeen_s = base::steadySeconds();
    const base::Topic source{MessageCode::HANDS_SOURCE};
    const base::Topic head{MessageCode::HANDS_SOURCE, 0, "head"};
    const bool hasFound = _log.begins(source, isAny); // each notes what it has found
    if (_log.begins(head, _heads.head().isTracked) || hasFound) _log.end(MessageCode::HANDS_SOURCE);
    for (base::Message& message : _hands.takeMessages())
        _log.say(std::move(message));
    for (base::Message& message : _heads.takeMessages())
        _log.say(std::move(message));
    const base::Topic recentred{MessageCode::HANDS_SOURCE, 0, "recentred"};
    const std::string moved = HandTracker::recentred();
    if (_log.begins(recentred, !moved.empty()))
        _log.say(recentred, {MessageCode::HANDS_SOURCE, moved});
    std::vector<base::Message> troubles = _hands.troubles();
    for (base::Message& message : _heads.troubles())
        troubles.push_back(std::move(message));
    _log.sayNow({MessageCode::HANDS_OPEN}, troubles);
}

std::string ScenePlayer::openHead(const std::string& text)
{
    if (text != _heads.named()) _log.end(MessageCode::HANDS_SOURCE);
    return _heads.setNamed(text);
}

void ScenePlayer::setHeadSource(std::shared_ptr<HeadSource> source)
{
    _log.end(MessageCode::HANDS_SOURCE);
    _heads.setSource(std::move(source));
}

std::string ScenePlayer::openHands(const std::string& uri)
{
    if (uri != _hands.named()) _log.end(MessageCode::HANDS_SOURCE);
    return _hands.setNamed(uri);
}

void ScenePlayer::setHandSource(std::shared_ptr<HandSource> source)
{
    _log.end(MessageCode::HANDS_SOURCE);
    _hands.setSource(std::move(source));
}

bool ScenePlayer::play(const Eigen::Isometry3d& handsToArray, bool isChanged)
{
    const double start_s = base::steadySeconds();
    noteSilence();
    const bool mayBeHeard = mayPlay() && mayListen();
    if (!mayBeHeard) _snapshot.objects.clear();
    locateHands(handsToArray);
    takeResult();
    _hands.touch(_snapshot.objects, playedNow());
    setLight();
    const bool isRefused =
        _taken.newest && !_taken.newest->playing && start_s - _submitted.since_s() > kRetry_s;
    const bool isCarried = _snapshot.carriesOn && _submitted.isMoving(start_s);
    const bool isIdle = _submitted.isAny() && !isRefused && !mayTouch() && !isCarried &&
                        !_submitted.differs(_snapshot, isChanged || !mayBeHeard);
    const bool isHandedOver = !isIdle && submit();
    rest();
    tellSlowSolver(start_s);
    tellFaintField(start_s);
    std::string headStatus = _heads.status(); // may call the application: no lock
    CoincidenceOptions known = knownErrors(handsToArray);
    const base::Lock lock(_shared.mutex);
    SceneStatistics& counts = _shared.counts;
    ++counts.frames;
    if (isIdle) ++counts.idleFrames;
    counts.hands = static_cast<int>(_hands.frame().hands.size());
    counts.touching = static_cast<int>(_hands.proximity().touches());
    counts.headTracked = _heads.head().isTracked;
    counts.head = std::move(headStatus);
    counts.predicted_ms = 1e3 * _hands.predictedBy_s();
    counts.temperature_C = _wanted.air_C;
    _shared.coincidence = std::move(known);
    return isHandedOver;
}

CoincidenceOptions ScenePlayer::knownErrors(const Eigen::Isometry3d& worldToArray) const
{
    const SceneSettings& settings = *_wanted.settings;
    const auto known = [](double error) -> std::optional<double>
    {
        if (error > 0.0) return error;
        return {};
    };
    constexpr double kThermometer_K = 0.5; // of a DS18B20, by its data sheet
    CoincidenceOptions options;
    options.seen = _times.viewing;
    options.array = _maker.array();
    options.worldToArray = worldToArray;
    options.temperature_C = _wanted.air_C;
    options.arrayError_m = known(settings.arrayError);
    options.headError_m = known(settings.headError);
    options.airError_K = known(settings.airError);
    if (!options.airError_K && !settings.temperatureSource.empty())
        options.airError_K = kThermometer_K;
    options.trackerError_m = known(settings.trackerError);
    return options;
}

void ScenePlayer::setLight()
{
    constexpr double kLongest_s = 0.2; // as that of the setting
    const std::optional<double> display_s = std::exchange(_times.display_s, std::nullopt);
    const double after_s = display_s.value_or(0.0) - _snapshot.time_s;
    const bool isLikely = display_s && std::abs(after_s) <= kLongest_s; // also false for NaN
    _snapshot.lightAfter_s = isLikely ? after_s : _wanted.settings->displayLatency;
    _snapshot.carriesOn = _wanted.settings->extrapolate;
}

// A limit applies to all ears, so nothing is played while the level at one of them is unknown.
bool ScenePlayer::mayListen()
{
    constexpr Eigen::Index kMostEars = 66; // of the program, plus two of a head
    Eigen::Matrix3Xd& ears = _snapshot.ears;
    if (ears.allFinite() && ears.cols() <= kMostEars) return true;
    const std::string why =
        ears.allFinite()
            ? fmt::format("there are {} ears, should be at most {}; nothing is played",
                          ears.cols(),
                          kMostEars - 2)
            : std::string("an ear is at a place that is not finite; nothing is played");
    ears.resize(3, 0);
    _log.say({MessageCode::SETTINGS_SILENCED, why});
    const base::Lock lock(_shared.mutex);
    _shared.whySilent = why;
    return false;
}

// Stores the reason for those who wait for a field.
void ScenePlayer::noteSilence()
{
    std::string why = whySilenced();
    if (why.empty() && !_wanted.settings->enabled)
    {
        why = "the scene is disabled";
        for (const base::Message& message : _log.messages())
            for (const MessageCode code : {MessageCode::SETTINGS_SILENCED,
                                           MessageCode::SETTINGS_CALIBRATION,
                                           MessageCode::SCENE_LIMIT})
                if (message.code == code) why = message.text;
    }
    const base::Lock lock(_shared.mutex);
    _shared.whySilent = std::move(why);
}

void ScenePlayer::rest()
{
    if (_opening.thread) _opening.thread->keepAlive();
}

// Contacts need frames while there are hands, and until touched objects have faded.
bool ScenePlayer::mayTouch() const
{
    constexpr double kFade_s = 0.5;
    const bool isAnyHand = base::steadySeconds() - _times.handsSeen_s < kFade_s;
    const Render ofScene = renderOf(_wanted.settings->render);
    const auto isTouchable = [ofScene](const HapticObject& object)
    { return followsHands(object.properties, ofScene); };
    return isAnyHand &&
           std::any_of(_snapshot.objects.begin(), _snapshot.objects.end(), isTouchable);
}

// Returns true if there is a thread; it then has the snapshot.
bool ScenePlayer::submit()
{
    _submitted.note(_snapshot, base::steadySeconds());
    if (!_opening.thread) return false;
    _opening.thread->submit(_snapshot);
    const base::Lock lock(_shared.mutex);
    ++_shared.counts.snapshots;
    return true;
}

void ScenePlayer::open()
{
    SceneSnapshot none;
    if (_opening.thread) _opening.thread->submit(none);
}

// Touches end before the snapshot is handed over.
void ScenePlayer::silence()
{
    if (!_opening.thread) return;
    _snapshot.objects.clear();
    _snapshot.time_s = base::steadySeconds();
    _hands.touch(_snapshot.objects, std::make_shared<PlayedPressure>());
    if (_submitted.differs(_snapshot, true)) submit();
}

// The pipeline is closed in its thread, which then has nothing to do and can be joined.
bool ScenePlayer::close()
{
    _wanted.on = {};
    if (std::exchange(_opening.isOpen, false) && _opening.thread)
    {
        _hands.setNamed("");
        _heads.setNamed("");
        _submitted.forget();
        _opening.thread->setPipeline([] { return std::unique_ptr<HologramPipeline>(); });
        silence();
        return true;
    }
    if (_opening.thread && _opening.thread->state() == ArrayState::CLOSED) end();
    return false;
}

std::shared_ptr<void> ScenePlayer::end()
{
    takeResult();
    _log.takeNew({}); // all its conditions have ended
    _hands.forgetTouches();
    _wanted.on = {};
    _opening.isOpen = false;
    _submitted.forget();
    _taken.results = 0;
    _taken.newest.reset();
    const base::Lock lock(_shared.mutex);
    if (_shared.thread) _shared.closed = _shared.thread->latestResult();
    _shared.thread = nullptr;
    _shared.counts.snapshots = 0; // counts of the next thread start at 0
    // The ending thread has no lead any more; the next one inherits the mute.
    const bool isMuted = _shared.lead->isMuted();
    _shared.lead = std::make_shared<device::Lead>();
    _shared.lead->setMuted(isMuted);
    return std::shared_ptr<HologramThread>(std::move(_opening.thread));
}

void ScenePlayer::setMuted(bool muted)
{
    const base::Lock lock(_shared.mutex);
    _shared.lead->setMuted(muted);
    if (_shared.thread) _shared.thread->setMuted(muted);
}

bool ScenePlayer::isMuted() const
{
    const base::Lock lock(_shared.mutex);
    return _shared.lead->isMuted();
}

void ScenePlayer::silenceNow()
{
    const base::Lock lock(_shared.mutex);
    if (_shared.thread) _shared.thread->silence();
}

void ScenePlayer::takeResult()
{
    const std::uint64_t results = _opening.thread ? _opening.thread->results() : 0;
    if (results == _taken.results) return;
    _taken.results = results;
    const auto result = latestResult();
    if (!result || result == _taken.newest) return;
    const bool isFresh = !_taken.newest || result->frame != _taken.newest->frame;
    _taken.newest = result;
    // Later results for the same frame at rest (fields in turn, outlines, figures) have no deadline
    // and don't count as latencies.
    if (isFresh)
    {
        const base::Lock lock(_shared.mutex);
        _shared.latencies.add(result->latency_ms);
        if (_hands.predicts())
        {
            const double latency_s = 1e-3 * _shared.latencies.percentile(0.5);
            _hands.setLatency(latency_s);
            _heads.setLatency(latency_s);
        }
    }
    std::vector<base::Message> told = result->told;
    // The grants have already reported a refused array, with a remedy.
    if (_played.on.isRefused)
        told.erase(std::remove_if(told.begin(),
                                  told.end(),
                                  [](const base::Message& message)
                                  { return message.code == MessageCode::ARRAY_REFUSED; }),
                   told.end());
    _log.takeNew(told);
}

// A program's own solver may take any time, and its thread can't report meanwhile.
void ScenePlayer::tellSlowSolver(double now_s)
{
    const base::Topic slow{MessageCode::SOLVER_SLOW};
    const double taken_s = _opening.thread ? _opening.thread->solvesFor_s() : 0.0;
    if (taken_s <= kSlowSolve_s)
    {
        if (now_s <= _taken.slowUntil_s) return;
        _taken.slowUntil_s = 0.0;
        _log.ends(slow);
        return;
    }
    const bool isTold = _taken.slowUntil_s > 0.0;
    _taken.slowUntil_s = now_s + kSlowOver_s;
    if (isTold) return;
    const bool isHeard = _taken.newest && _taken.newest->playing && _submitted.hasObjects();
    _log.begins(slow);
    _log.say(slow,
             {MessageCode::SOLVER_SLOW,
              fmt::format(
                  "the solver has been working on one field for {:.1f} s; {}",
                  taken_s,
                  isHeard ? fmt::format("still playing the field of frame {}", _taken.newest->frame)
                          : "nothing is played meanwhile")});
}

// What fades in or out, or is touched only just, isn't told.
void ScenePlayer::tellFaintField(double now_s)
{
    const base::Topic faint{MessageCode::FIELD_FAINT};
    const auto& field = _taken.newest;
    const bool isFaint = field && field->state == ArrayState::PLAYING &&
                         field->fingertip.strength() == haptics::Strength::TOO_WEAK;
    if (!isFaint)
    {
        if (_taken.isFaintTold) _log.ends(faint);
        _taken.isFaintTold = false;
        _taken.faintSince_s = now_s;
        return;
    }
    if (_taken.isFaintTold || now_s - _taken.faintSince_s < kFaint_s) return;
    _taken.isFaintTold = true;
    _log.begins(faint);
    _log.say(faint,
             {MessageCode::FIELD_FAINT,
              fmt::format("most people can't feel this field: a fingertip gets {} where it is "
                          "strongest",
                          haptics::forceText(field->fingertip.force_N))});
}

// --- Any thread ----------------------------------------------------------------------------------

std::shared_ptr<const HologramResult> ScenePlayer::latestResult() const
{
    const base::Lock lock(_shared.mutex);
    return _shared.thread ? _shared.thread->latestResult() : _shared.closed;
}

std::string ScenePlayer::awaitField(double timeout_s) const
{
    std::shared_ptr<HologramThread::Progress> progress;
    std::uint64_t snapshots = 0;
    {
        const base::Lock lock(_shared.mutex);
        if (!_shared.whySilent.empty()) return "nothing is played: " + _shared.whySilent;
        if (!_shared.thread) return "nothing is played: it is closed, or has not begun";
        progress = _shared.thread->progress();
        snapshots = _shared.thread->submitted();
    }
    if (snapshots == 0) return "nothing is played: there was no frame so far";
    if (!progress->await(snapshots, timeout_s > 0.0 ? timeout_s : 0.0))
        return progress->isEnded() ? "nothing is played: it was closed meanwhile"
                                   : fmt::format("there is no field after {:g} s", timeout_s);
    const auto result = latestResult();
    if (result && result->array && !result->sequence.fields.empty()) return {};
    return "nothing is played: " + (result && !result->report().message.empty()
                                        ? result->report().message
                                        : std::string("it is closed"));
}

std::vector<haptics::PlaceExposure> ScenePlayer::ears() const
{
    const base::Lock lock(_shared.mutex);
    return _shared.thread ? _shared.thread->ears() : std::vector<haptics::PlaceExposure>();
}

std::vector<CoincidenceFigures> ScenePlayer::coincidence() const
{
    CoincidenceOptions known;
    std::vector<SeenObject> seen;
    {
        const base::Lock lock(_shared.mutex);
        if (_shared.thread) seen = _shared.thread->seen();
        known = _shared.coincidence;
    }
    std::vector<CoincidenceFigures> all; // without the lock, because it takes a while
    all.reserve(seen.size());
    for (const SeenObject& object : seen)
        all.push_back(coincidenceOf(known, object));
    return all;
}

SceneStatistics ScenePlayer::statistics() const
{
    SceneStatistics all = counted();
    all.coincidence = coincidence();
    return all;
}

// The statistics without the coincidence errors.
SceneStatistics ScenePlayer::counted() const
{
    const base::Lock lock(_shared.mutex);
    SceneStatistics all = _shared.counts;
    all.latencyP50_ms = _shared.latencies.percentile(0.5);
    all.latencyP99_ms = _shared.latencies.percentile(0.99);
    all.messages = _log.all();
    if (!_shared.thread) return all;
    base::assignPart<HologramCounters>(all, _shared.thread->counters());
    all.snapshots = _shared.counts.snapshots; // the thread counts those that it has processed
    all.processed = _shared.thread->processed();
    ArrayReading reading = _shared.thread->reading();
    all.state = reading.state;
    all.fields = reading.fields;
    all.device = std::move(reading.status);
    all.exposure = _shared.thread->exposure();
    all.ears = _shared.thread->ears();
    if (const auto result = _shared.thread->latestResult()) addFigures(*result, all);
    return all;
}

ArrayState ScenePlayer::state() const
{
    const base::Lock lock(_shared.mutex);
    return _shared.thread ? _shared.thread->state() : ArrayState::CLOSED;
}

ArrayReading ScenePlayer::reading() const
{
    const base::Lock lock(_shared.mutex);
    return _shared.thread ? _shared.thread->reading() : ArrayReading();
}

PlayedDrives ScenePlayer::playedOfLate(double duration_s) const
{
    const base::Lock lock(_shared.mutex);
    return _shared.thread ? _shared.thread->playedOfLate(duration_s) : PlayedDrives();
}

haptics::Medium ScenePlayer::medium() const
{
    const base::Lock lock(_shared.mutex);
    return _shared.medium;
}

std::shared_ptr<const PlayedPressure> ScenePlayer::playedNow() const
{
    const base::Lock lock(_shared.mutex);
    return _shared.thread ? _shared.thread->playedNow() : std::make_shared<PlayedPressure>();
}

} // namespace midair::bridge
