#include "engine-bridge/player/PipelineMaker.h"

#include "device/opening/MultiDevice.h"
#include "haptics/array/ArrayFileWatch.h"
#include "haptics/base/InputError.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"

#include <cstdint>
#include <utility>

namespace midair::bridge
{

using base::MessageCode;

struct PipelineMaker::Loaded
{
    haptics::ArrayFileWatch watch{""}; ///< used by the hologram thread only
    std::uint64_t rereads = 0;         ///< likewise; how often the file changed and was valid
    mutable base::Mutex mutex;
    std::shared_ptr<const haptics::TransducerArray> array MIDAIR_GUARDED_BY(mutex);
};

namespace
{

/// Message for a changed array file.
std::string readAgain(const haptics::TransducerArray& array)
{
    return "array \"" + array.name + "\" has changed and was read again: " +
           std::to_string(array.size() - static_cast<int>(array.dead.size())) + " of " +
           std::to_string(array.size()) + " transducers are driven";
}

} // namespace

haptics::TransducerArray
arrayOn(const PlayedOn& on, const std::string& dead, const std::string& weak)
{
    try
    {
        if (on.array.empty() && !on.make) throw base::InputError("there is no array");
        haptics::TransducerArray array =
            on.array.empty() ? on.make() : haptics::TransducerArray::load(on.array);
        array.mark(dead, weak);
        return array;
    }
    catch (const std::exception& error)
    {
        // There is one message per code: the grants' own message stays.
        throw base::CodedError(on.isRefused ? MessageCode::ARRAY_REFUSED
                                            : MessageCode::ARRAY_INVALID,
                               std::string(error.what()) + "; nothing is played");
    }
}

void PipelineMaker::begin(const PlayedOn& on, const std::string& dead, const std::string& weak)
{
    if (!_begun || on.device != _on.device) _begun = std::make_shared<std::atomic<bool>>(false);
    _on = on;
    _dead = dead;
    _weak = weak;
    auto loaded = std::make_shared<Loaded>();
    std::atomic_store(&_loaded, std::move(loaded));
}

HologramThread::PipelineFactory PipelineMaker::factory(const HologramOptions& given) const
{
    return [options = given,
            on = _on,
            dead = _dead,
            weak = _weak,
            loaded = _loaded,
            begun = _begun]() mutable
    {
        // Also after a failed read; a setting may ask for a new pipeline as well.
        const bool isAnother = loaded->watch.wasChanged();
        if (!on.array.empty()) loaded->watch = haptics::ArrayFileWatch(on.array);
        options.array = arrayOn(on, dead, weak);
        {
            const base::Lock lock(loaded->mutex);
            if (isAnother)
            {
                options.notes = {{MessageCode::ARRAY_READ_AGAIN, readAgain(options.array)}};
                options.notes[0].count = ++loaded->rereads;
            }
            loaded->array = std::make_shared<haptics::TransducerArray>(options.array);
        }
        // Another pipeline of this scene on the same device continues its recording.
        if (*begun) options.deviceUri = device::continuedRecordings(options.deviceUri);
        auto pipeline = std::make_unique<HologramPipeline>(options);
        *begun = true;
        return pipeline;
    };
}

HologramThread::StaleCheck PipelineMaker::staleCheck() const
{
    return [loaded = _loaded] { return loaded->watch.isChanged(base::steadySeconds()); };
}

std::shared_ptr<const haptics::TransducerArray> PipelineMaker::array() const
{
    const std::shared_ptr<Loaded> loaded = std::atomic_load(&_loaded);
    if (!loaded) return nullptr;
    const base::Lock lock(loaded->mutex);
    return loaded->array;
}

} // namespace midair::bridge
