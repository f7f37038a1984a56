#include "engine-bridge/HologramThread.h"

#include <utility>

namespace midair::bridge
{

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
    _slot.close();
    _thread.join();
}

void HologramThread::setPipeline(PipelineFactory makePipeline)
{
    const std::lock_guard<std::mutex> lock(_mutex);
    _newPipeline.swap(makePipeline);
}

void HologramThread::submit(SceneSnapshot& snapshot)
{
    _slot.put(snapshot);
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
        const auto taken =
            _slot.take(snapshot, pipeline ? pipeline->rest_s() : HologramPipeline::kAttend_s);
        if (taken == LatestSlot<SceneSnapshot>::Taken::CLOSED) return;
        if (taken == LatestSlot<SceneSnapshot>::Taken::NOTHING)
        {
            const auto result = pipeline ? pipeline->attend() : nullptr;
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

void HologramThread::makePipeline(std::unique_ptr<HologramPipeline>& pipeline)
{
    PipelineFactory make;
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        make.swap(_newPipeline);
    }
    if (!make) return;
    pipeline.reset();
    try
    {
        pipeline = make();
        if (pipeline) return;
        auto result = std::make_shared<HologramResult>();
        result->report.stop = haptics::StopReason::NOTHING_TO_DO;
        result->deviceStatus = "not open";
        publish(result, {});
    }
    catch (const std::exception& error)
    {
        auto result = std::make_shared<HologramResult>();
        result->report.stop = haptics::StopReason::REFUSED;
        result->report.message = error.what();
        result->messages.emplace_back(error.what());
        result->deviceStatus = "not open";
        publish(result, {});
    }
}

} // namespace midair::bridge
