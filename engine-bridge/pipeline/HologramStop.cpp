// HologramPipeline: what it keeps to whatever is asked for, and how it is broken off and silenced.
#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/base/Limits.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/threads/ThreadPool.h"

#include <algorithm>

namespace midair::bridge
{

namespace
{

constexpr int kMostFields = 256; // that are played in turn
constexpr double kLeastMonitorInterval_s = 0.05;

} // namespace

// What is asked for beyond what the machine has, or than is good for it, is said and not done.
void HologramPipeline::keepToLimits()
{
    int& threads = _options.solverOptions.threads;
    const int cores = base::coreCount();
    if (threads > cores)
    {
        const std::string number = std::to_string(cores);
        _messages.say("threads is " + std::to_string(threads) + "; this machine has " + number +
                      (cores == 1 ? " core: 1 is used" : " cores: " + number + " are used"));
        threads = cores;
    }
    if (!_options.solverOptions.pool)
        _options.solverOptions.pool = std::make_shared<base::ThreadPool>(threads);
    const auto keepBelow = [this](const char* name, int& value, int most, const std::string& why)
    {
        if (value <= most) return;
        _messages.say(std::string(name) + " is " + std::to_string(value) + "; " + why +
                      " at most " + std::to_string(most));
        value = most;
    };
    const auto transducers = static_cast<std::size_t>(_options.array.size());
    const std::size_t most =
        std::min(std::size_t(base::kMostControlPoints), base::kMostEntries / transducers);
    keepBelow("maxPoints",
              _options.maxPoints,
              std::max(1, static_cast<int>(most)),
              "the control points of a field of this array are");
    const std::string cycle = "with a cycle of " + std::to_string(_options.cycle) + " it is";
    keepBelow("subsets", _options.subsets, kMostFields / _options.cycle, cycle);
    keepBelow("cycleSteps", _options.cycleSteps, kMostFields / _options.cycle - 1, cycle);
    double& interval_s = _options.monitorInterval_s;
    if (!(interval_s > 0.0 && interval_s < kLeastMonitorInterval_s)) return;
    _messages.say("monitorInterval_s is " + base::shortNumber(interval_s) +
                  "; a field is looked at every " + base::shortNumber(kLeastMonitorInterval_s) +
                  " s at most");
    interval_s = kLeastMonitorInterval_s;
}

void HologramPipeline::setStop(const base::StopToken& stop)
{
    _options.solverOptions.stop = stop;
    _assembler->setStop(stop);
}

void HologramPipeline::silenceDevice()
{
    _holds = false;
    silenceNow();
}

void HologramPipeline::silenceNow()
{
    const std::lock_guard<std::mutex> lock(_sending);
    if (_player) _player->stop(); // or it would play on over the silence
    if (_device) _device->silence();
}

void HologramPipeline::silence()
{
    _playing = false;
    silenceDevice();
}

std::shared_ptr<const HologramResult> HologramPipeline::stopped(const SceneSnapshot& snapshot)
{
    silence();
    auto result = std::make_shared<HologramResult>();
    result->report.stop = haptics::StopReason::STOPPED;
    result->report.message = base::Stopped().what();
    result->report.transducers = _options.array.size();
    result->played.setZero(_options.array.size());
    finish(snapshot, *result);
    return result;
}

} // namespace midair::bridge
