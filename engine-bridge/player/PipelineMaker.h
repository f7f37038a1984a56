#pragma once

#include "engine-bridge/pipeline/HologramThread.h"
#include "haptics/array/TransducerArray.h"

#include <atomic>
#include <functional>
#include <memory>
#include <string>

namespace midair::bridge
{

/// Array and device of a scene.
struct PlayedOn
{
    /// name or path of the array; its file is watched, and read again after a change. Empty: \a
    /// described
    std::string array;
    /// identity of an array that the program made, used only for comparison; null: none
    std::shared_ptr<const void> described;
    /// makes that array; throws base::InputError
    std::function<haptics::TransducerArray()> make;
    bool isRefused = false; ///< the user's grants refuse the array, and have reported it
    std::string device;     ///< URI

    bool operator==(const PlayedOn& other) const
    {
        return array == other.array && described == other.described && device == other.device;
    }
};

/// Reads that array and marks the transducers of the settings \a dead and \a weak. Throws
/// base::CodedError.
haptics::TransducerArray
arrayOn(const PlayedOn& on, const std::string& dead, const std::string& weak);

/// Makes the pipelines of one scene in its hologram thread, so that no frame waits for a file.
/// Reads the array, watches its file, and continues recordings that it has begun.
class PipelineMaker
{
public:
    /// Later pipelines use \a on, with the transducers of the settings \a dead and \a weak.
    void begin(const PlayedOn& on, const std::string& dead, const std::string& weak);

    /// Returns a factory for pipelines with \a options, except for their array and device. The
    /// factory throws base::CodedError if the array can't be read.
    HologramThread::PipelineFactory factory(const HologramOptions& options) const;
    /// Returns a check whether the array's file has changed; to be called in the hologram thread.
    HologramThread::StaleCheck staleCheck() const;

    /// Array of the newest pipeline; null: none was made yet. Any thread.
    std::shared_ptr<const haptics::TransducerArray> array() const;

private:
    /// What the hologram thread has loaded.
    struct Loaded;

    PlayedOn _on;
    std::string _dead;
    std::string _weak;
    std::shared_ptr<Loaded> _loaded;
    std::shared_ptr<std::atomic<bool>> _begun; ///< a pipeline was opened on the device
};

} // namespace midair::bridge
