#pragma once

#include "engine-bridge/pipeline/HologramThread.h"
#include "haptics/array/TransducerArray.h"

#include <atomic>
#include <functional>
#include <memory>
#include <string>

namespace midair::bridge
{

/// What a scene is played on.
struct PlayedOn
{
    /// name or path of the array; its file is watched, and read again when it has changed. Empty:
    /// the array is described
    std::string array;
    /// what describes an array of the program's own, which is compared alone; null: none
    std::shared_ptr<const void> described;
    /// makes that array; throws base::InputError
    std::function<haptics::TransducerArray()> make;
    bool isRefused = false; ///< the array, by the user's grants, which have said so
    std::string device;     ///< URI

    bool operator==(const PlayedOn& other) const
    {
        return array == other.array && described == other.described && device == other.device;
    }
};

/// Reads that array, with the transducers that the settings call \a dead and \a weak. Throws
/// base::CodedError.
haptics::TransducerArray
arrayOn(const PlayedOn& on, const std::string& dead, const std::string& weak);

/// Makes the pipelines of one scene in its hologram thread, so that no frame waits for a file:
/// reads the array, watches its file, and goes on with recordings that it has begun.
class PipelineMaker
{
public:
    /// The pipelines made from now on are for \a on, with the transducers that the settings call
    /// \a dead and \a weak.
    void begin(const PlayedOn& on, const std::string& dead, const std::string& weak);

    /// Makes a pipeline with \a options but for its array and device. It throws base::CodedError
    /// if the array can't be had.
    HologramThread::PipelineFactory factory(const HologramOptions& options) const;
    /// Whether the array's file has changed. For the hologram thread.
    HologramThread::StaleCheck staleCheck() const;

    /// The array as the newest pipeline has it; null: none was made yet. Any thread.
    std::shared_ptr<const haptics::TransducerArray> array() const;

private:
    /// What the hologram thread has loaded.
    struct Loaded;

    PlayedOn _on;
    std::string _dead;
    std::string _weak;
    std::shared_ptr<Loaded> _loaded;
    std::shared_ptr<std::atomic<bool>> _begun; ///< there was a pipeline on the device
};

} // namespace midair::bridge
