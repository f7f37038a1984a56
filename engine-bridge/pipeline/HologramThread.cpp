#include "engine-bridge/pipeline/HologramThread.h"

#include "haptics/base/threads/SteadyClock.h"

#include <utility>

namespace midair::bridge
{

namespace
{

// A snapshot breaks off attend() only once it has run for this long. Work that is broken off starts
// again, so with a steady stream of snapshots that move nothing it would never be done.
constexpr double kPatience_s = 0.5;

} // namespace

HologramThread::HologramThread(HologramOptions options) :
    HologramThread([options = std::move(options)]
                   { return std::make_unique<HologramPipeline>(options); })
{
}

HologramThread::HologramThread(PipelineFactory makePipeline) :
    _newPipeline(std::move(makePipeline)),
    _thread([this] { run(); })
{
}

HologramThread::~HologramThread()
{
    _slot.close([this] { _stop.request(); });
    silenceNow();
    _thread.join();
}

void HologramThread::setPipeline(PipelineFactory makePipeline)
{
    _slot.between(
        [&](bool, bool)
        {
            const std::lock_guard<std::mutex> lock(_mutex);
            _newPipeline.swap(makePipeline);
            _stop.request();
        });
}

void HologramThread::submit(SceneSnapshot& snapshot)
{
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
    const std::lock_guard<std::mutex> lock(_atWorkMutex);
    _atWork = pipeline;
}

// Called after the stop was requested, so that the pipeline doesn't send the field it works on.
void HologramThread::silenceNow()
{
    const std::lock_guard<std::mutex> lock(_atWorkMutex);
    if (_atWork) _atWork->silenceNow();
}

std::shared_ptr<const HologramResult> HologramThread::latestResult() const
{
    const std::lock_guard<std::mutex> lock(_mutex);
    return _result;
}

HologramCounters HologramThread::counters() const
{
    HologramCounters counters;
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        counters = _counters;
    }
    return counters;
}

void HologramThread::publish(std::shared_ptr<const HologramResult> result,
                             const HologramCounters& counters)
{
    const std::lock_guard<std::mutex> lock(_mutex);
    _result.swap(result); // the old one dies with the argument, outside the lock
    _counters = counters;
    ++_results;
}

void HologramThread::run()
{
    std::unique_ptr<HologramPipeline> pipeline;
    SceneSnapshot snapshot;
    std::uint64_t droppedBefore = 0;
    for (;;)
    {
        const auto taken = _slot.take(snapshot,
                                      pipeline ? pipeline->rest_s() : HologramPipeline::kAttend_s,
                                      [this] { _stop.clear(); });
        if (taken == base::LatestSlot<SceneSnapshot>::Taken::CLOSED) return setAtWork(nullptr);
        if (taken == base::LatestSlot<SceneSnapshot>::Taken::NOTHING)
        {
            _restWorkSince_s = base::steadySeconds();
            const auto result = pipeline ? pipeline->attend() : nullptr;
            _restWorkSince_s = 0.0;
            if (result) publish(result, pipeline->counters());
            continue;
        }
        makePipeline(pipeline);
        const std::uint64_t dropped = _slot.drops();
        if (pipeline)
        {
            const auto result = pipeline->process(snapshot, dropped - droppedBefore);
            publish(result, pipeline->counters());
        }
        droppedBefore = dropped;
    }
}

void HologramThread::publishClosed(haptics::StopReason stop, const std::string& why)
{
    auto result = std::make_shared<HologramResult>();
    result->sequence.report.stop = stop;
    result->sequence.report.message = why;
    if (!why.empty()) result->messages.push_back(why);
    result->deviceStatus = "not open";
    publish(result, {});
}

void HologramThread::makePipeline(std::unique_ptr<HologramPipeline>& pipeline)
{
    PipelineFactory make;
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        make.swap(_newPipeline);
    }
    if (!make) return;
    setAtWork(nullptr);
    pipeline.reset();
    try
    {
        pipeline = make();
        if (!pipeline) publishClosed(haptics::StopReason::NOTHING_TO_DO, {});
    }
    catch (const std::exception& error)
    {
        publishClosed(haptics::StopReason::REFUSED, error.what());
    }
    if (!pipeline) return;
    pipeline->setStop(_stop.token());
    setAtWork(pipeline.get());
    // A stop that was requested for the old pipeline must not stop this one; a stop requested for a
    // snapshot, pipeline or end that still waits stays.
    _slot.between(
        [this](bool isWaiting, bool isClosed)
        {
            const std::lock_guard<std::mutex> lock(_mutex);
            if (!isWaiting && !isClosed && !_newPipeline) _stop.clear();
        });
}

} // namespace midair::bridge
