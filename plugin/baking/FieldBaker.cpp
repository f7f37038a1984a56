#include "device/ArrayDevice.h"
#include "device/DeviceUri.h"
#include "device/FieldCounters.h"
#include "device/drive/DriveEncoder.h"
#include "device/limits/GuardedDevice.h"
#include "device/opening/MultiDevice.h"
#include "engine-bridge/extending/OwnSolver.h"
#include "engine-bridge/hands/opening/HandOpening.h"
#include "engine-bridge/playing/FieldPlayer.h"
#include "engine-bridge/scene/GeometryReader.h"
#include "engine-bridge/sensations/SensationRenderer.h"
#include "haptics/base/Bytes.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/simd/InstructionSet.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/threads/Forks.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"
#include "haptics/solvers/ManyStarts.h"
#include "plugin/engine/SceneAccess.h"
#include "plugin/hands/KitHands.h"
#include "plugin/scene/SceneCollector.h"
#include "plugin/settings/AllSettings.h"
#include "plugin/settings/Grants.h"

#include <osgMidair/FieldBaker>
#include <osgMidair/FoundObject>
#include <osgMidair/HapticScene>
#include <osgMidair/HapticSettings>
#include <osgMidair/RigidBodyCallback>

#include <osg/ImageStream>
#include <osg/Node>
#include <osg/NodeVisitor>
#include <osg/Texture>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <complex>
#include <stdexcept>

#include <fmt/format.h>

namespace osgMidair
{

/// The limits in a device URI.
struct BakedLimits
{
    midair::device::SafetyLimits limits; ///< those enforced in a recording: maxima
    /// Sentences on those that a device enforces itself, because they act over time.
    std::vector<std::string> unkept;
};

constexpr double kSecond_ns = 1e9;

/// The clock for baking: it advances only when the baker moves it on, from frame to frame, or from
/// field to field with hands or sensations.
class BakingClock : public midair::base::Clock
{
public:
    double now_s() const override { return static_cast<double>(now_ns()) / kSecond_ns; }
    void wait(midair::base::Condition& condition,
              midair::base::Lock& lock,
              double /*until_s*/) const override
    {
        condition.wait(lock);
    }
    std::uint64_t now_ns() const { return _now_ns; }
    void set(std::uint64_t now_ns) { _now_ns = now_ns; }

private:
    std::atomic<std::uint64_t> _now_ns{0};
};

/// The fields sent to a BakingDevice, on a BakingClock. Any thread.
class SentFields
{
public:
    void add(std::uint64_t time_ns, const midair::device::DriveSignal& signal)
    {
        const midair::base::Lock lock(_mutex);
        if (!_fields.empty() && _fields.back().time_ns == time_ns) _fields.pop_back();
        _fields.push_back({time_ns, signal.phase, signal.duty});
    }
    std::vector<BakedField> take()
    {
        const midair::base::Lock lock(_mutex);
        return std::exchange(_fields, {});
    }

private:
    midair::base::Mutex _mutex;
    std::vector<BakedField> _fields MIDAIR_GUARDED_BY(_mutex);
};

/// The hands of a recording, starting at the first frame.
class BakedHands : public HandSource
{
public:
    explicit BakedHands(const midair::bridge::RecordedUri& uri) :
        _hands(std::make_shared<midair::bridge::RecordedHandSource>(uri.file, uri.loops))
    {
    }
    bool getHands(double time_s, std::vector<Hand>& hands) override
    {
        hands.clear();
        midair::bridge::HandFrame frame;
        if (!_hands.frameAt(time_s, frame)) return false;
        for (const midair::bridge::Hand& hand : frame.hands)
            hands.push_back(fromBridge(hand));
        return true;
    }
    std::string getStatus() const override { return _hands.status(); }

private:
    midair::bridge::FromItsBegin _hands;
};

namespace
{

/// The device of a FieldBaker's pipeline: accepts every field at once and plays nothing. Fields of
/// objects are read from the pipeline's results, fields of contacts from what it is sent.
class BakingDevice : public midair::device::ArrayDevice
{
public:
    BakingDevice(int transducers, const BakingClock& clock, std::shared_ptr<SentFields> sent) :
        _held(transducers),
        _clock(clock),
        _sent(std::move(sent))
    {
    }

    bool send(const midair::device::DriveSignal& signal) override
    {
        if (!signal.fits(_held.transducers()))
        {
            _counters.countRefused();
            return false;
        }
        _held.replace(signal);
        if (_sent) _sent->add(_clock.now_ns(), signal);
        _counters.countPlayed(midair::base::steadySeconds());
        return true;
    }

    bool sendSequence(const midair::device::DriveSequence& sequence) override
    {
        if (!sequence.fits(_held.transducers()))
        {
            _counters.countRefused();
            return false;
        }
        return send(sequence.signals.front());
    }

    void silence() override
    {
        if (_sent && !_held.silent()) _sent->add(_clock.now_ns(), {});
        _held.clear();
    }
    std::string status() const override { return "baked into a recording"; }
    midair::device::DeviceReport report() const override { return _counters.report(); }

    midair::device::DriveAbility ability() const override
    {
        midair::device::DriveAbility ability;
        // Whole periods of up to this many steps are handed over in one piece; nothing is sent step
        // by step.
        ability.sequenceFields = 1 << 14;
        return ability;
    }

    std::vector<std::complex<float>> played() const override { return _held.activations(); }

private:
    midair::device::HeldField _held;
    midair::device::FieldCounters _counters;
    const BakingClock& _clock;
    const std::shared_ptr<SentFields> _sent; ///< null: not recorded
};

/// Finds nodes that move or change by themselves over time.
class FindLive : public osg::NodeVisitor
{
public:
    FindLive() : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN) { setNodeMaskOverride(~0U); }

    void apply(osg::Node& node) override
    {
        const auto add = [&](const std::string& what)
        {
            std::string told = printable(midair::bridge::quoted(node)) + ": " + what;
            if (std::find(found.begin(), found.end(), told) == found.end())
                found.push_back(std::move(told));
        };
        for (const osg::Callback* callback = node.getUpdateCallback(); callback;
             callback = callback->getNestedCallback())
            if (dynamic_cast<const RigidBodyCallback*>(callback))
                add("a rigid body moves it, at the pace of the wall clock");
        if (std::string(node.libraryName()) == "osgParticle")
            add("its particles are random and differ each time");
        if (hasFilm(node.getStateSet()))
            add("its texture is a film, which plays by the wall clock");
        traverse(node);
    }

    std::vector<std::string> found;

private:
    static bool hasFilm(const osg::StateSet* state)
    {
        if (!state) return false;
        for (unsigned int unit = 0; unit < state->getNumTextureAttributeLists(); ++unit)
        {
            const auto* texture = dynamic_cast<const osg::Texture*>(
                state->getTextureAttribute(unit, osg::StateAttribute::TEXTURE));
            for (unsigned int i = 0; texture && i < texture->getNumImages(); ++i)
                if (dynamic_cast<const osg::ImageStream*>(texture->getImage(i))) return true;
        }
        return false;
    }
};

/// Reads the limits from \a uri; of several URIs separated by commas, the strictest. Throws
/// midair::device::DeviceError on errors.
BakedLimits limitsOfDevice(const std::string& uri)
{
    using midair::device::SafetyLimits;
    BakedLimits all;
    for (const std::string& one : midair::device::splitDeviceList(uri))
    {
        midair::device::DeviceUri parsed(one);
        const SafetyLimits limits = midair::device::takeLimits(parsed, {});
        SafetyLimits& kept = all.limits;
        kept.maxAmplitude = std::min(kept.maxAmplitude, limits.maxAmplitude);
        kept.maxPressure_Pa =
            midair::device::stricterCap(kept.maxPressure_Pa, limits.maxPressure_Pa);
        const auto leave = [&](const char* name, bool isSet)
        {
            if (!isSet) return;
            all.unkept.push_back(fmt::format(
                "{} of the device \"{}\" acts at playback and isn't in a recording: set "
                "it on the device that plays, play:FILE?to={}:..?{}=..",
                name,
                one,
                parsed.scheme(),
                name));
        };
        leave("ramp", limits.ramp_s > 0.0);
        leave("mean-drive", limits.meanDrive < 1.0);
        leave("hold", limits.hold_s > 0.0);
    }
    return all;
}

/// Adds to \a all the parts that depend on hands unknown in advance.
void addLiveHands(const HapticSettings& settings,
                  const std::vector<FoundObject>& found,
                  bool hasOwnHands,
                  std::vector<std::string>& all)
{
    if (hasOwnHands || (!settings.hands.empty() && settings.hands != "none"))
        all.push_back(fmt::format("hands \"{}\": their positions during playback are unknown",
                                  hasOwnHands ? "of the program" : printable(settings.hands)));
    if (settings.reach > 0.0)
        all.push_back(
            fmt::format("reach is {:g} m: only points near a hand are played, and there is "
                        "no hand, so nothing would be played",
                        settings.reach));
    const bool isContactByDefault = settings.render != HapticSettings::OBJECT;
    if (isContactByDefault) all.emplace_back("render is contact or auto: contacts need hands");
    for (const FoundObject& object : found)
    {
        const auto own = object.property.render;
        if (own == HapticProperty::CONTACT || own == HapticProperty::AUTO)
            all.push_back(object.path + ": its render is contact or auto: contacts need hands");
        const midair::bridge::SensationProperties sensation = forBridge(object.property).sensation;
        if (sensation.needsHands()) all.push_back(object.path + ": its sensation needs hands");
    }
}

/// Returns sentences on parts of \a scene that depend on the wall clock or on visitors, and so are
/// unknown in advance. \a settings: those in effect. \a hasOwnHands: the program has set a source
/// of hands. Recorded hands and their contacts are known.
std::vector<std::string> unbakeable(osg::Node& scene,
                                    const HapticSettings& settings,
                                    const std::vector<FoundObject>& found,
                                    bool hasOwnHands)
{
    std::vector<std::string> all;
    const bool areKnown = !hasOwnHands && midair::bridge::RecordedUri::parse(settings.hands);
    if (areKnown && settings.prediction != HapticSettings::OFF)
        all.emplace_back("prediction: recorded hands need none; set prediction=off");
    if (!areKnown) addLiveHands(settings, found, hasOwnHands, all);
    if (settings.earCamera)
        all.emplace_back("earCamera: there is no camera, so the head's position is unknown");
    FindLive finder;
    scene.accept(finder);
    std::sort(finder.found.begin(), finder.found.end());
    all.insert(all.end(), finder.found.begin(), finder.found.end());
    return all;
}

using midair::bridge::HologramOptions;
using midair::bridge::HologramPipeline;
using midair::bridge::HologramResult;
using midair::device::DriveSignal;
using midair::haptics::StopReason;

constexpr std::size_t kMostHandBytes = std::size_t(64) << 20;
constexpr int kMostRest = 100000; // limit on steps of a frame at rest; the constants end it before

/// Throws std::runtime_error.
[[noreturn]] void fail(const std::string& why)
{
    throw std::runtime_error(why);
}

std::string valueText(const Setting<HapticSettings>& row, const HapticSettings& settings)
{
    const bool isNumber = std::holds_alternative<int HapticSettings::*>(row.member) ||
                          std::holds_alternative<double HapticSettings::*>(row.member);
    return isNumber ? midair::base::exactNumber(row.number(settings)) : row.defaultText(settings);
}

std::string crcText(const std::string& text)
{
    return fmt::format(
        "{:08x}",
        midair::base::crc32c(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

/// Appends \a signals to \a frame, in step with the recording's clock.
void addSteps(const std::vector<DriveSignal>& signals,
              const midair::haptics::ModulatorOptions& modulation,
              std::uint64_t begin_ns,
              std::uint64_t end_ns,
              BakedFrame& frame)
{
    const midair::haptics::Modulator modulator(modulation);
    const double step_ns = kSecond_ns / modulation.fieldRate_Hz;
    auto step = static_cast<std::int64_t>(std::floor(static_cast<double>(begin_ns) / step_ns));
    std::uint64_t time_ns = begin_ns;
    while (time_ns < end_ns)
    {
        DriveSignal signal;
        midair::bridge::signalOfStep(signals, modulator, step, signal);
        frame.fields.push_back({time_ns, std::move(signal.phase), std::move(signal.duty)});
        do
            time_ns =
                static_cast<std::uint64_t>(std::llround(static_cast<double>(++step) * step_ns));
        while (time_ns <= frame.fields.back().time_ns);
    }
}

} // namespace

/// The state of a FieldBaker.
struct FieldBaker::Part
{
    Part(HapticScene& baked, int wantedThreads) : scene(&baked), threads(wantedThreads) {}
    ~Part() { leaveParents(); }
    Part(const Part&) = delete;
    Part& operator=(const Part&) = delete;

    // In the child of a fork the solver's threads belong to the parent.
    void leaveParents()
    {
        if (!isOurs) static_cast<void>(pipeline.release());
        isOurs = {};
    }

    void collect(const osg::FrameStamp& stamp, const osg::Matrixd& world)
    {
        leaveParents();
        HapticEngine& engine = SceneAccess::engine(*scene);
        const auto look = [&]
        {
            collected = engine.collectForBaking(
                {scene.get(), world}, stamp.getFrameNumber(), stamp.getSimulationTime());
        };
        look();
        if (openHands(engine)) look();
        if (!collected.snapshot)
            fail("the HapticScene \"" + scene->getName() +
                 "\" is inside another one, which plays it");
        const HapticSettings granted = engine.grantedSettings();
        if (granted.isSilenced)
            fail("the scene isn't played: " +
                 (granted.whySilenced.empty() ? "isSilenced is set" : granted.whySilenced.front()));
        const std::vector<midair::bridge::HapticObject>& objects = collected.snapshot->objects;
        const bool hadSensations = std::exchange(
            touches.areSensations, midair::bridge::SensationRenderer::concerns(objects));
        if (hadSensations != touches.areSensations) touches.last.clear();
        if (hadSensations != touches.areSensations && !hands)
            pipeline.reset(); // its device records or not
        limits = limitsOfDevice(granted.device);
        if (pipeline && opened != collected.settings) pipeline.reset();
    }

    // Returns true if the hands come from a recording from now on.
    bool openHands(HapticEngine& engine)
    {
        const HapticSettings granted = engine.grantedSettings();
        const auto uri = midair::bridge::RecordedUri::parse(granted.hands);
        if (hands || scene->getHandSource() || !uri) return false;
        hands = new BakedHands(*uri);
        handsText = midair::base::readRegularFile(uri->file, kMostHandBytes);
        engine.setHandSource(hands);
        pipeline.reset(); // its device records from now on
        return true;
    }

    void open()
    {
        if (pipeline) return;
        pipeline = SceneAccess::engine(*scene).makePipeline(options());
        opened = collected.settings;
        keepArray();
    }

    // The most accurate options, without a device.
    HologramOptions options()
    {
        HologramOptions options = SceneAccess::engine(*scene).optionsForBaking();
        options.deviceUri = "baked:";
        options.deviceFactory = [this, most = limits.limits](
                                    const std::string&, const midair::device::DeviceLayout& layout)
        {
            return std::make_unique<midair::device::GuardedDevice>(
                std::make_unique<BakingDevice>(
                    layout.transducers, clock, isPlayedOn() ? touches.sent : nullptr),
                most,
                layout.transducers);
        };
        options.clock = &clock;
        options.restAfter_s = 0.0;
        options.solverFactory =
            [](const std::string& name, const midair::haptics::SolverOptions& wanted)
        {
            const auto make = [name](const midair::haptics::SolverOptions& each)
            { return midair::bridge::makeAnySolver(name, each); };
            return std::make_unique<midair::haptics::ManyStarts>(make, wanted, kStarts);
        };
        midair::haptics::SolverOptions& solver = options.solverOptions;
        solver.threads = threads;
        solver.deadline_ms = 0.0;
        solver.maxIterations = 0;
        solver.rmsTolerance = std::min(solver.rmsTolerance, kTolerance);
        solver.thorough = true;
        options.monitorInterval = 0.0;
        options.reopen_s = 0.0;
        return options;
    }

    void keepArray()
    {
        const auto array = SceneAccess::engine(*scene).array();
        std::string text = array ? array->toJson() : "";
        if (!arrayText.empty() && text != arrayText) fail("the array has changed during baking");
        arrayText = std::move(text);
        transducers = array ? static_cast<unsigned int>(array->size()) : 0;
    }

    // Completes everything that a scene at rest gets step by step.
    std::shared_ptr<const HologramResult> solve()
    {
        if (isPlayedOn()) touches.snapshot = *collected.snapshot;
        if (isPlayedOn()) touches.snapshot.time_s = clock.now_s();
        auto result = pipeline->process(isPlayedOn() ? touches.snapshot : *collected.snapshot);
        for (int more = 0; more < kMostRest && pipeline->rest_s() <= 0.0; ++more)
            if (auto better = pipeline->attend()) result = better;
        for (const midair::base::Message& message : result->told)
            if (std::none_of(told.begin(),
                             told.end(),
                             [&](const midair::base::Message& one)
                             { return one.code == message.code && one.path == message.path; }))
                told.push_back(message);
        const StopReason stop = result->report().stop;
        if (stop == StopReason::REFUSED || stop == StopReason::STOPPED || !result->deviceOpen)
            fail(result->report().message.empty() ? midair::haptics::stopReasonName(stop)
                                                  : result->report().message);
        return result;
    }

    // True if fields come between frames: of contacts or sensations.
    bool isPlayedOn() const { return hands || touches.areSensations; }

    // Returns the fields of contacts and sensations between two frames.
    std::vector<BakedField> playOn(std::uint64_t end_ns)
    {
        if (!isPlayedOn()) return {};
        touches.sent->take();
        // A field is due when its period is over, with a margin for rounding errors.
        const double rate_Hz = SceneAccess::engine(*scene).grantedSettings().fieldRate;
        const auto step_ns = static_cast<std::uint64_t>(std::ceil(kSecond_ns / rate_Hz)) + 1;
        for (std::uint64_t now_ns = clock.now_ns() + step_ns; now_ns < end_ns; now_ns += step_ns)
        {
            clock.set(now_ns);
            for (int more = 0; more == 0 || (more < kMostRest && pipeline->rest_s() <= 0.0); ++more)
                pipeline->attend();
        }
        return touches.sent->take();
    }

    // Returns the fields' levels; none for a silence.
    std::vector<DriveSignal> encoded(const HologramResult& result) const
    {
        std::vector<DriveSignal> signals;
        bool sounds = false;
        for (const Eigen::VectorXcf& q : result.sequence.fields)
        {
            DriveSignal& signal = signals.emplace_back();
            if (!midair::device::encode(q.data(), static_cast<int>(q.size()), signal) ||
                signal.size() != static_cast<int>(transducers))
                fail("the field isn't one finite number for each transducer");
            sounds = sounds || std::any_of(signal.duty.begin(),
                                           signal.duty.end(),
                                           [](std::uint8_t level) { return level > 0; });
        }
        if (!sounds) signals.clear();
        return signals;
    }

    void fill(const HologramResult& result,
              std::uint64_t begin_ns,
              std::uint64_t end_ns,
              BakedFrame& frame) const;

    const osg::ref_ptr<HapticScene> scene;
    const int threads;
    HapticEngine::Baked collected;
    std::uint64_t opened = 0; ///< Baked::settings of the pipeline
    BakedLimits limits;
    std::string arrayText; ///< JSON of the array; empty: not read yet
    unsigned int transducers = 0;
    /// Contacts of recorded hands, and sensations, between frames.
    struct Touches
    {
        bool areSensations = false; ///< of the newest frame
        std::shared_ptr<SentFields> sent = std::make_shared<SentFields>();
        midair::bridge::SceneSnapshot snapshot; ///< of the newest frame, by the clock
        std::vector<BakedField> last;           ///< of the frame before; empty: no contact
    };

    midair::base::MadeHere isOurs; ///< the pipeline
    BakingClock clock;
    osg::ref_ptr<BakedHands> hands; ///< null: none, or not from a recording
    std::string handsText;          ///< their file
    Touches touches;
    std::unique_ptr<HologramPipeline> pipeline;
    std::vector<midair::base::Message> told; ///< of pipelines
};

FieldBaker::FieldBaker(HapticScene& scene, int threads) :
    _part(std::make_unique<Part>(scene, threads))
{
}

FieldBaker::~FieldBaker() = default;

bool FieldBaker::look(const osg::FrameStamp& stamp, const osg::Matrixd& world, std::string& error)
{
    try
    {
        _part->collect(stamp, world);
        if (SceneAccess::engine(*_part->scene).grantedSettings().enabled) _part->open();
        return true;
    }
    catch (...)
    {
        error = midair::base::whatWasThrown();
        return false;
    }
}

std::vector<std::string> FieldBaker::getUnbakeable() const
{
    HapticScene& scene = *_part->scene;
    return unbakeable(scene,
                      scene.getGrantedSettings(),
                      scene.getFoundObjects(),
                      scene.getHandSource() && scene.getHandSource() != _part->hands);
}

std::vector<std::string> FieldBaker::getUnkept() const
{
    return _part->limits.unkept;
}

std::vector<std::pair<std::string, std::string>> FieldBaker::getIdentity() const
{
    using midair::base::exactNumber;
    const HapticSettings settings = _part->scene->getGrantedSettings();
    std::vector<std::pair<std::string, std::string>> all = {
        {"kit", MIDAIR_VERSION},
        {"instructions", midair::base::instructionSetName(midair::base::instructionSet())},
        {"array", crcText(_part->arrayText)},
        {"transducers", std::to_string(_part->transducers)},
        {"deviceMaxAmplitude", exactNumber(_part->limits.limits.maxAmplitude)},
        {"deviceMaxPressure", exactNumber(_part->limits.limits.maxPressure_Pa)}};
    if (_part->hands) all.emplace_back("handRecording", crcText(_part->handsText));
    for (const Setting<HapticSettings>& row : sceneSettings().rows())
        if (row.isIdentity) all.emplace_back(row.name, valueText(row, settings));
    return all;
}

unsigned int FieldBaker::getNumTransducers() const
{
    return _part->transducers;
}

void FieldBaker::restart()
{
    using midair::base::MessageCode;
    if (_part->pipeline && _part->touches.areSensations)
        _part->told.push_back({MessageCode::SENSATION_LIMITED,
                               "sensations begin anew with each chunk; one chunk for all frames "
                               "keeps their course"});
    _part->pipeline.reset();
    _part->touches.last.clear();
}

// Adds the figures of \a result, and its fields if the frame has none yet.
void FieldBaker::Part::fill(const HologramResult& result,
                            std::uint64_t begin_ns,
                            std::uint64_t end_ns,
                            BakedFrame& frame) const
{
    frame.points = static_cast<unsigned int>(result.points.size());
    frame.isSilenced = result.isSilenced();
    std::vector<DriveSignal> signals = encoded(result);
    if (!signals.empty())
    {
        frame.rms = result.report().rms;
        frame.loudness = result.report().loudness;
        frame.level_Pa = result.report().level_Pa;
        frame.isEvened = result.sequence.evened;
    }
    if (!frame.fields.empty()) return;
    if (signals.empty())
        frame.fields.push_back({begin_ns, {}, {}});
    else if (result.sequence.changes())
        addSteps(signals, result.sequence.modulation, begin_ns, end_ns, frame);
    else
        frame.fields.push_back(
            {begin_ns, std::move(signals.front().phase), std::move(signals.front().duty)});
}

bool FieldBaker::bake(const osg::FrameStamp& stamp,
                      const osg::Matrixd& world,
                      std::uint64_t begin_ns,
                      std::uint64_t end_ns,
                      BakedFrame& frame,
                      std::string& error)
{
    frame = {};
    try
    {
        if (end_ns <= begin_ns) fail("the frame ends before it has begun");
        _part->clock.set(begin_ns);
        _part->collect(stamp, world);
        if (!SceneAccess::engine(*_part->scene).grantedSettings().enabled)
        {
            frame.fields.push_back({begin_ns, {}, {}});
            return true;
        }
        _part->open();
        _part->touches.sent->take();
        const auto result = _part->solve();
        const bool goesOn = _part->touches.sent->take().empty() && !_part->touches.last.empty();
        std::vector<BakedField> touched = _part->playOn(end_ns);
        if (goesOn)
        {
            frame.fields.push_back(_part->touches.last.back());
            frame.fields.back().time_ns = begin_ns;
        }
        _part->fill(*result, begin_ns, touched.empty() ? end_ns : touched.front().time_ns, frame);
        frame.fields.insert(frame.fields.end(), touched.begin(), touched.end());
        _part->touches.last = std::move(touched);
        return true;
    }
    catch (...)
    {
        error = midair::base::whatWasThrown();
        _part->pipeline.reset();
        return false;
    }
}

std::vector<HapticMessage> FieldBaker::getMessages() const
{
    std::vector<HapticMessage> all = _part->scene->getStatistics().told;
    for (const midair::base::Message& message : _part->told)
        all.push_back(toPublic(message));
    return all;
}

} // namespace osgMidair
