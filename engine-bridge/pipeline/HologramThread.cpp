#include "engine-bridge/pipeline/HologramThread.h"

#include "haptics/base/ThrownBy.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/base/threads/Punctual.h"
#include "haptics/base/threads/SteadyClock.h"

#include <utility>

namespace midair::bridge
{

namespace
{

// A snapshot interrupts attend() only after it has run for this long. Interrupted work starts
// again, so with a steady stream of unmoved snapshots it would never finish.
constexpr double kPatience_s = 0.5;

} // namespace

HologramThread::HologramThread(HologramOptions options) :
    HologramThread([options = std::move(options)]
                   { return std::make_unique<HologramPipeline>(options); })
{
}

HologramThread::HologramThread(PipelineFactory makePipeline,
                               StaleCheck isStale,
                               std::shared_ptr<device::Lead> lead) :
    _lead(std::move(lead)),
    _wanted{{std::move(makePipeline), std::move(isStale)}, {}, {}},
    _thread([this] { run(); })
{
    keepAlive();
}

HologramThread::~HologramThread()
{
    _progress->end();
    _slot.close([this] { _stop.request(); });
    silenceNow();
    _thread.join();
}

void HologramThread::setPipeline(PipelineFactory makePipeline, StaleCheck isStale)
{
    Maker maker{std::move(makePipeline), std::move(isStale)}; // the old one dies outside the locks
    _slot.between(
        [&](bool, bool)
        {
            const base::Lock lock(_mutex);
            std::swap(_wanted.maker, maker);
            _wanted.options.reset();
            _wanted.otherwise = nullptr;
            _opening = true;
            _stop.request();
        });
}

void HologramThread::setOptions(HologramOptions options, PipelineFactory otherwise)
{
    const double amplitude = options.maxAmplitude;
    bool isStricter = true; // stricter than those of a pipeline being made, as far as known
    {
        const base::Lock lock(_atWorkMutex);
        if (_atWork) isStricter = _atWork->isStricter(options);
    }
    _slot.between(
        [&](bool, bool)
        {
            const base::Lock lock(_mutex);
            if (_wanted.maker.make)
            {
                _wanted.maker.make = std::move(otherwise); // it wasn't made yet
                return;
            }
            _wanted.options = std::move(options);
            _wanted.otherwise = std::move(otherwise);
            if (isStricter) _stop.request();
        });
    const base::Lock lock(_atWorkMutex);
    if (!_atWork) return;
    _atWork->device().lowerAmplitudeCap(amplitude);
    if (isStricter) _atWork->device().silenceNow();
}

void HologramThread::setMuted(bool muted)
{
    {
        const base::Lock lock(_atWorkMutex);
        _lead->setMuted(muted);
        if (_atWork) _atWork->device().setMuted(muted);
    }
    _slot.wake(); // attend() plays the field again, or tells that it is muted
}

void HologramThread::silence()
{
    _slot.between([this](bool, bool) { _stop.request(); });
    silenceNow();
}

ArrayState HologramThread::state() const
{
    return _opening ? ArrayState::OPENING : reading().state;
}

// An open device has its own state, even before the first result.
ArrayReading HologramThread::reading() const
{
    {
        const base::Lock lock(_atWorkMutex);
        if (_atWork) return _atWork->device().reading();
    }
    ArrayReading now;
    if (_opening) now.state = ArrayState::OPENING;
    const auto result = latestResult();
    if (result) now.status = result->deviceStatus;
    return now;
}

std::shared_ptr<const PlayedPressure> HologramThread::playedNow() const
{
    auto played = std::make_shared<PlayedPressure>();
    const auto newest = latestResult();
    if (!newest || !newest->playing || newest->achieved_Pa.size() != newest->points.size() ||
        reading().state != ArrayState::PLAYING)
        return played;
    played->positions = newest->points.positions;
    played->pressure_Pa = newest->achieved_Pa;
    return played;
}

PlayedDrives HologramThread::playedOfLate(double duration_s) const
{
    const base::Lock lock(_atWorkMutex);
    return _atWork ? _atWork->device().playedOfLate(duration_s) : PlayedDrives();
}

haptics::ExposureFigures HologramThread::exposure() const
{
    {
        const base::Lock lock(_atWorkMutex);
        if (_atWork) return _atWork->exposure();
    }
    const auto result = latestResult();
    return result ? result->exposure : haptics::ExposureFigures();
}

std::vector<SeenObject> HologramThread::seen() const
{
    const base::Lock lock(_atWorkMutex);
    return _atWork ? _atWork->seen() : std::vector<SeenObject>();
}

std::vector<haptics::PlaceExposure> HologramThread::ears() const
{
    const base::Lock lock(_atWorkMutex);
    return _atWork ? _atWork->ears() : std::vector<haptics::PlaceExposure>();
}

bool HologramThread::Progress::await(std::uint64_t snapshots, double timeout_s)
{
    const double until_s = base::steadySeconds() + timeout_s;
    base::Lock lock(_mutex);
    while (_processed < snapshots && !_isEnded && base::steadySeconds() < until_s)
        _changed.waitUntil_s(lock, until_s);
    return _processed >= snapshots;
}

bool HologramThread::Progress::isEnded() const
{
    const base::Lock lock(_mutex);
    return _isEnded;
}

void HologramThread::Progress::advance(std::uint64_t snapshots)
{
    const base::Lock lock(_mutex);
    _processed += snapshots;
    _changed.notifyAll();
}

void HologramThread::Progress::end()
{
    const base::Lock lock(_mutex);
    _isEnded = true;
    _changed.notifyAll();
}

double HologramThread::solvesFor_s() const
{
    double since_s = 0.0;
    {
        const base::Lock lock(_atWorkMutex);
        if (_atWork) since_s = _atWork->solvingSince_s();
    }
    return since_s > 0.0 && _slot.isFull() ? base::steadySeconds() - since_s : 0.0;
}

void HologramThread::submit(SceneSnapshot& snapshot)
{
    keepAlive(); // before the field that may follow at once
    const bool isSilence = snapshot.objects.empty();
    const auto request = [&]
    {
        const double since_s = _restWorkSince_s;
        if (isSilence || (since_s > 0.0 && base::steadySeconds() - since_s > kPatience_s))
            _stop.request();
    };
    if (_slot.put(snapshot, request) && isSilence) silenceNow();
}

void HologramThread::setAtWork(HologramPipeline* pipeline)
{
    const base::Lock lock(_atWorkMutex);
    _atWork = pipeline;
    if (_atWork) _atWork->device().follow(_lead);
}

// Called after the stop was requested, so that the pipeline doesn't send its present field.
void HologramThread::silenceNow()
{
    const base::Lock lock(_atWorkMutex);
    if (_atWork) _atWork->device().silenceNow();
}

std::shared_ptr<const HologramResult> HologramThread::latestResult() const
{
    const base::Lock lock(_mutex);
    return _published.result;
}

HologramCounters HologramThread::counters() const
{
    const base::Lock lock(_mutex);
    return _published.counters;
}

void HologramThread::publish(std::shared_ptr<const HologramResult> result,
                             const HologramCounters& counters)
{
    const base::Lock lock(_mutex);
    _published.result.swap(result); // the old one dies with the argument, outside the lock
    _published.counters = counters;
    _opening = _wanted.maker.make != nullptr; // another pipeline may be wanted by now
    ++_results;
}

void HologramThread::run()
{
    base::wakePunctually();
    std::unique_ptr<HologramPipeline> pipeline;
    SceneSnapshot snapshot;
    Maker maker;
    bool hasSnapshot = false;
    std::uint64_t droppedBefore = 0;
    for (;;)
    {
        const double rest_s =
            pipeline && !hasNewOptions() ? pipeline->rest_s() : HologramPipeline::kAttend_s;
        const auto taken = _slot.take(snapshot, rest_s, [this] { _stop.clear(); });
        if (taken == base::LatestSlot<SceneSnapshot>::Taken::CLOSED) return setAtWork(nullptr);
        if (taken == base::LatestSlot<SceneSnapshot>::Taken::NOTHING)
        {
            if (hasNewOptions()) continue; // their snapshot is on its way
            if (hasSnapshot && maker.isStale && maker.isStale())
            {
                makePipeline(maker, pipeline);
                if (pipeline) publish(pipeline->process(snapshot), pipeline->counters());
                continue;
            }
            if (hasSnapshot && pipeline && pipeline->isOpenedNow())
            {
                publish(pipeline->process(snapshot), pipeline->counters());
                continue;
            }
            _restWorkSince_s = base::steadySeconds();
            const auto result = pipeline ? pipeline->attend() : nullptr;
            _restWorkSince_s = 0.0;
            if (result) publish(result, pipeline->counters());
            continue;
        }
        hasSnapshot = true;
        const bool isNew = takeMaker(maker);
        const bool isOutdated = useNewOptions(maker, pipeline);
        if (isNew || isOutdated || (maker.isStale && maker.isStale()))
            makePipeline(maker, pipeline);
        const std::uint64_t dropped = _slot.drops();
        if (pipeline)
        {
            pipeline->isOpenedNow();
            const auto result = pipeline->process(snapshot, dropped - droppedBefore);
            publish(result, pipeline->counters());
        }
        _progress->advance(1 + dropped - droppedBefore);
        droppedBefore = dropped;
    }
}

void HologramThread::publishClosed(haptics::StopReason stop,
                                   const std::optional<base::Message>& why)
{
    auto result = std::make_shared<HologramResult>();
    result->sequence.report.stop = stop;
    if (why)
    {
        result->sequence.report.message = why->text;
        result->messages.push_back(why->text);
        result->told.push_back(*why);
    }
    result->deviceStatus = "not open";
    publish(result, {});
}

// Returns false, with \a maker unchanged, if there is no new one.
bool HologramThread::takeMaker(Maker& maker)
{
    const base::Lock lock(_mutex);
    if (!_wanted.maker.make) return false;
    maker = std::exchange(_wanted.maker, {});
    return true;
}

bool HologramThread::hasNewOptions() const
{
    const base::Lock lock(_mutex);
    return _wanted.options.has_value();
}

// Returns true if there are new options and no pipeline to take them. Pipelines that \a maker makes
// later have them, too: otherwise a cap that was lowered could come back.
bool HologramThread::useNewOptions(Maker& maker, std::unique_ptr<HologramPipeline>& pipeline)
{
    bool isOutdated = false;
    for (;;)
    {
        std::optional<HologramOptions> options;
        {
            const base::Lock lock(_mutex);
            options.swap(_wanted.options);
            if (options) maker.make = std::exchange(_wanted.otherwise, nullptr);
        }
        if (!options) return isOutdated;
        isOutdated = !pipeline;
        if (pipeline) pipeline->reconfigure(std::move(*options));
    }
}

// Opening a device may take a while, and a cap set meanwhile applies to the very first field.
void HologramThread::makePipeline(Maker& maker, std::unique_ptr<HologramPipeline>& pipeline)
{
    do
        makeOnce(maker.make, pipeline);
    while (useNewOptions(maker, pipeline));
}

void HologramThread::makeOnce(const PipelineFactory& make,
                              std::unique_ptr<HologramPipeline>& pipeline)
{
    setAtWork(nullptr);
    pipeline.reset();
    _opening = true;
    try
    {
        pipeline = make();
        if (!pipeline) publishClosed(haptics::StopReason::NOTHING_TO_DO, {});
    }
    catch (const base::CodedError& error)
    {
        publishClosed(haptics::StopReason::REFUSED, base::Message(error.code, error.what()));
    }
    catch (...)
    {
        publishClosed(haptics::StopReason::REFUSED,
                      base::Message(base::MessageCode::SCENE_CLOSED, base::whatWasThrown()));
    }
    if (!pipeline) return;
    pipeline->setStop(_stop.token());
    setAtWork(pipeline.get());
    // A stop requested for the old pipeline must not stop this one; a stop for a snapshot, pipeline
    // or end that still waits stays.
    _slot.between(
        [this](bool isWaiting, bool isClosed)
        {
            const base::Lock lock(_mutex);
            if (!isWaiting && !isClosed && !_wanted.maker.make) _stop.clear();
        });
}

} // namespace midair::bridge
