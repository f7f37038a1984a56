#include "plugin/engine/HapticEngine.h"

#include "engine-bridge/playing/EarWatch.h"
#include "haptics/base/AssignPart.h"
#include "haptics/base/threads/SteadyClock.h"
#include "plugin/engine/PublicMessage.h"
#include "plugin/report/DeviceLines.h"
#include "plugin/report/Report.h"
#include "plugin/settings/Grants.h"
#include "plugin/settings/PropertyChanges.h"

#include <osg/Notify>
#include <osgViewer/View>

#include <algorithm>
#include <utility>

namespace osgMidair
{

using midair::base::Message;
using midair::base::MessageCode;
using midair::bridge::HapticObject;

namespace
{

/// Time before a field that the device refused is tried again.
constexpr double kRetry_s = 0.5;

std::shared_ptr<const midair::bridge::PlayedPressure> nothingPlayed()
{
    return std::make_shared<midair::bridge::PlayedPressure>();
}

bool sameObject(const HapticObject& a, const HapticObject& b)
{
    return a.id == b.id && a.meshId == b.meshId && a.properties == b.properties &&
           a.clips == b.clips && a.pose.matrix() == b.pose.matrix();
}

} // namespace

HapticEngine::HapticEngine(osg::Node& root, const HapticSettings& settings, OwnerKind kind) :
    osg::Referenced(true),
    _root(&root),
    _owner(root, kind, *this),
    _joined(*this),
    _kind(kind),
    _given(&settings),
    _collector(kind == OwnerKind::SCENE ? &root : nullptr,
               [this](const Message& message) { say(message); })
{
    collectDeviceLines();
}

HapticEngine::~HapticEngine()
{
    takeResult();
    tellLines(midair::base::steadySeconds() + midair::base::LineLimit::kPause_s);
    const ReportedScene last{statistics(), _settings, field()};
    _thread.reset();
    tellDeviceLines();
    if (_isReported) writeReport(this, last);
}

osg::ref_ptr<osg::Node> HapticEngine::root() const
{
    osg::ref_ptr<osg::Node> node;
    _root.lock(node);
    return node;
}

// Returns false if the objects are the same as in the last frame. What _snapshot held before says
// nothing of that: it is an older one once another has been handed over.
bool HapticEngine::collect(const std::vector<SceneRoot>& roots)
{
    if (_settings.enabled) return _collector.collect(roots, _snapshot.objects);
    _collector.forget();
    _snapshot.objects.clear();
    return true;
}

bool HapticEngine::rests(const osg::Node& root)
{
    if (!_rest.possible) return false;
    root.getBound(); // recomputed if something below has moved
    const double now_s = midair::base::steadySeconds();
    if (_rest.bounds == 0 || _rest.bounds != _rest.boundsSeen ||
        _rest.changesSeen != propertyChanges() || !(*_given == _raw) ||
        now_s - _rest.submitTime_s < kRest_s || now_s - _rest.lookTime_s > kLook_s)
        return false;
    ++_rest.frames;
    if (_thread) _thread->keepAlive();
    return true;
}

void HapticEngine::update(const std::vector<SceneRoot>& roots,
                          unsigned int frame,
                          double age_s,
                          double simulationTime_s)
{
    const double start_s = midair::base::steadySeconds();
    _rest.lookTime_s = start_s;
    _rest.boundsSeen = _rest.bounds;
    _rest.changesSeen = propertyChanges();
    tellDeviceLines();
    tellLines(start_s);
    if (standsBack()) return tellState();
    if (_isCrowded && _place.take()) _configured = false; // there is one now
    configure(*_given);
    followThermometer();
    const bool fresh = collect(roots);
    keepInnerLimits();
    _snapshot.frame = frame;
    _snapshot.time_s = start_s - age_s;
    _snapshot.metresPerUnit = _settings.metresPerUnit;
    _snapshot.simulationTime_s = simulationTime_s;
    _snapshot.worldToArray = _toArray;
    attachMouse();
    listenAtCamera();
    _hands.locate(simulationTime_s, _worldToArray, _snapshot.around);
    _snapshot.hands = _hands.frame();
    _snapshot.handsLate_s = _hands.late_s();
    if (!_snapshot.hands.hands.empty()) _handsSeen_s = start_s;
    for (Message& message : _hands.takeMessages())
        say(std::move(message));
    if (_settings.enabled) _collector.addObstacles(_snapshot.around.props);
    takeResult();
    _hands.touch(_snapshot.objects, _thread ? _thread->playedNow() : nothingPlayed());
    const bool refused = _seen && !_seen->playing && start_s - _rest.submitTime_s > kRetry_s;
    const bool idle = _submittedAny && !refused && !changedSinceSubmitted(fresh);
    if (!idle) submit();
    if (_thread) _thread->keepAlive();
    tellSlowSolver(start_s);
    const int beingRead = _settings.enabled ? _collector.beingRead() : 0;
    _rest.possible =
        _submittedAny && !_hands.active() && beingRead == 0 && _snapshot.ears.cols() == 0;

    {
        const std::lock_guard<std::mutex> lock(_mutex);
        ++_statistics.frames;
        if (idle) ++_statistics.idleFrames;
        _statistics.meshesRead = _collector.extractions();
        _statistics.objectsBeingRead = beingRead;
        _statistics.objects = _settings.enabled ? _collector.instances() : 0;
        _statistics.hands = _hands.hands();
        _statistics.touching = _hands.touching();
        _statistics.predicted_ms = 1e3 * _hands.predictedBy_s();
        _statistics.temperature_C = _air_C;
        _statistics.collect_ms = (midair::base::steadySeconds() - start_s) * 1e3;
    }
    if (_isReported && isReportDue(this)) keepReport(this, {statistics(), _settings, field()});
    tellTouches();
    tellState();
}

void HapticEngine::tellTouches()
{
    if (!_hands.hasEvents()) return;
    const Eigen::Affine3d arrayToScene(Eigen::Matrix4d(_toArray.inverse()));
    const auto told =
        _hands.gather([this](std::uint64_t id) { return _collector.nodeOf(id); }, arrayToScene);
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _touches = _hands.current();
    }
    for (Message& message : _hands.tell(told))
        say(std::move(message));
}

void HapticEngine::silence()
{
    if (!_thread) return;
    _collector.forget();
    _snapshot.objects.clear();
    _snapshot.time_s = midair::base::steadySeconds();
    _hands.touch(_snapshot.objects,
                 nothingPlayed()); // ends all touches; before the snapshot is handed over
    if (!_submittedAny || changedSinceSubmitted(true)) submit();
    tellTouches();
    tellState();
}

void HapticEngine::setMuted(bool muted)
{
    const std::lock_guard<std::mutex> lock(_mutex);
    _muted = muted;
    if (_thread) _thread->setMuted(muted);
}

// Contacts live on frames while there are hands, and for as long as what was touched still fades.
bool HapticEngine::mayTouch() const
{
    constexpr double kFade_s = 0.5;
    const bool isAnyHand = midair::base::steadySeconds() - _handsSeen_s < kFade_s;
    return isAnyHand && std::any_of(_snapshot.objects.begin(),
                                    _snapshot.objects.end(),
                                    [this](const midair::bridge::HapticObject& object)
                                    {
                                        using midair::bridge::Render;
                                        const Render own = object.properties.render;
                                        return own == Render::INHERIT
                                                   ? _settings.render != HapticSettings::OBJECT
                                                   : own != Render::OBJECT;
                                    });
}

bool HapticEngine::changedSinceSubmitted(bool objectsToo) const
{
    if (!midair::bridge::equivalent(_snapshot.around, _submittedAround)) return true;
    if (mayTouch()) return true;
    const Eigen::Matrix3Xd& ears = _snapshot.ears;
    if (ears.cols() != _submittedEars.cols() ||
        (ears.cols() > 0 && !((ears - _submittedEars).colwise().norm().maxCoeff() <=
                              midair::bridge::EarWatch::kTolerance_m)))
        return true;
    return objectsToo && !std::equal(_snapshot.objects.begin(),
                                     _snapshot.objects.end(),
                                     _submitted.begin(),
                                     _submitted.end(),
                                     sameObject);
}

void HapticEngine::submit()
{
    _submitted = _snapshot.objects;
    _submittedAround = _snapshot.around;
    _submittedEars = _snapshot.ears;
    _submittedAny = true;
    _rest.submitTime_s = midair::base::steadySeconds();
    if (!_thread) return;
    _thread->submit(_snapshot);
    _collector.forget(); // _snapshot now holds the objects of an older one
    const std::lock_guard<std::mutex> lock(_mutex);
    ++_statistics.snapshots;
}

std::string HapticEngine::name() const
{
    const osg::ref_ptr<osg::Node> node = root();
    std::string named = node && !node->getName().empty() ? " \"" + node->getName() + "\"" : "";
    const osg::Group* group = node && named.empty() ? node->asGroup() : nullptr;
    for (unsigned int i = 0; group && named.empty() && i < group->getNumChildren(); ++i)
        if (!group->getChild(i)->getName().empty())
            named = " with \"" + group->getChild(i)->getName() + "\"";
    return _kind == OwnerKind::SCENE ? (named.empty() ? "a HapticScene" : "the HapticScene" + named)
           : _kind == OwnerKind::CALLBACK ? "a HapticCallback"
                                          : "the viewer's --device";
}

void HapticEngine::takeResult()
{
    const std::uint64_t results = _thread ? _thread->results() : 0;
    if (results == _resultsSeen) return;
    _resultsSeen = results;
    const auto result = latestResult();
    if (!result || result == _seen) return;
    const bool fresh = !_seen || result->frame != _seen->frame;
    _seen = result;
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        // Later results for the same frame at rest (fields in turn, outlines, figures) have no
        // deadline, so they are no latencies.
        if (fresh) _latencies.add(result->latency_ms);
    }
    if (fresh && _hands.predicts()) _hands.setLatency(1e-3 * _latencies.percentile(0.5));
    takeMessages(*result);
}

std::shared_ptr<const midair::bridge::HologramResult> HapticEngine::latestResult() const
{
    const std::lock_guard<std::mutex> lock(_mutex);
    return _thread ? _thread->latestResult() : _closed;
}

midair::bridge::PlayedDrives HapticEngine::playedOfLate(double duration_s) const
{
    const std::lock_guard<std::mutex> lock(_mutex);
    return _thread ? _thread->playedOfLate(duration_s) : midair::bridge::PlayedDrives();
}

std::shared_ptr<const midair::haptics::TransducerArray> HapticEngine::array() const
{
    std::shared_ptr<LoadedArray> loaded;
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        loaded = _array;
    }
    if (!loaded) return nullptr;
    const std::lock_guard<std::mutex> lock(loaded->mutex);
    return loaded->array;
}

midair::haptics::Medium HapticEngine::medium() const
{
    const std::lock_guard<std::mutex> lock(_mutex);
    return _medium;
}

std::vector<Touch> HapticEngine::touches() const
{
    const std::lock_guard<std::mutex> lock(_mutex);
    std::vector<Touch> touches = _touches;
    // It may have been muted or lost since the frame.
    if (!_thread || _thread->reading().state != ArrayState::PLAYING)
        for (Touch& touch : touches)
            touch.force = 0.0;
    return touches;
}

HapticStatistics HapticEngine::statistics() const
{
    const std::lock_guard<std::mutex> lock(_mutex);
    HapticStatistics all = _statistics;
    all.messages = _messages.all();
    for (const Message& message : _messages.messages())
        all.told.push_back(toPublic(message));
    all.restingFrames = _rest.frames;
    all.frames += all.restingFrames;
    all.idleFrames += all.restingFrames;
    all.latencyP50_ms = _latencies.percentile(0.5);
    all.latencyP99_ms = _latencies.percentile(0.99);
    if (!_thread) return all;
    midair::base::assignPart<midair::bridge::HologramCounters>(all, _thread->counters());
    all.snapshots = _statistics.snapshots; // the thread counts those that it has come to
    all.processed = _thread->processed();
    midair::bridge::ArrayReading reading = _thread->reading();
    all.state = reading.state;
    all.fields = reading.fields;
    all.device = std::move(reading.status);
    all.exposure = _thread->exposure();
    const auto result = _thread->latestResult();
    if (!result) return all;
    midair::base::assignPart<midair::haptics::FieldFigures>(all, result->report());
    all.fieldFrame = result->frame;
    all.points = result->points.size();
    all.maxPressure_Pa = result->maxPressure_Pa;
    const bool inTurn = result->sequence.fields.size() > 1;
    all.fieldsInTurn = inTurn ? static_cast<int>(result->sequence.fields.size()) : 0;
    all.fieldRate_Hz = inTurn ? result->sequence.modulation.fieldRate_Hz : 0.0;
    all.outline = result->outline;
    if (result->monitored && result->monitored->certificate.points > 0)
        all.certifiedGap = result->monitored->certificate.gapOfPhases();
    all.figures = midair::haptics::figuresOf(result->report());
    all.updatesPerSecond = result->updatesPerSecond;
    all.latency_ms = result->latency_ms;
    all.stop = midair::haptics::stopReasonName(result->report().stop);
    return all;
}

} // namespace osgMidair
