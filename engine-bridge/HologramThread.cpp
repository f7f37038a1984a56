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
    _thread([this, makePipeline = std::move(makePipeline)] { run(makePipeline); })
{
}

HologramThread::~HologramThread()
{
    _slot.close();
    _thread.join();
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
}

void HologramThread::run(const PipelineFactory& makePipeline)
{
    std::unique_ptr<HologramPipeline> pipeline;
    try
    {
        pipeline = makePipeline();
    }
    catch (const std::exception& error)
    {
        refuseAll(error.what());
        return;
    }
    SceneSnapshot snapshot;
    std::uint64_t droppedBefore = 0;
    while (_slot.take(snapshot))
    {
        const std::uint64_t dropped = _slot.drops();
        const auto result = pipeline->process(snapshot, dropped - droppedBefore);
        droppedBefore = dropped;
        publish(result, pipeline->counters());
    }
}

void HologramThread::refuseAll(const std::string& why)
{
    auto result = std::make_shared<HologramResult>();
    result->report.stop = haptics::StopReason::REFUSED;
    result->report.message = why;
    result->messages.push_back(why);
    result->deviceStatus = "not open";
    publish(result, {});
}

} // namespace midair::bridge
