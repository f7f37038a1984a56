#pragma once

#include "engine-bridge/HapticObject.h"
#include "engine-bridge/pipeline/HologramOptions.h"
#include "haptics/sequence/FieldMonitor.h"
#include "haptics/sequence/FieldSequence.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace midair::bridge
{

/// Has what is played certified and its surface measured now and then, beside the solver, where the
/// options ask for that.
class PlayedFieldMonitor
{
public:
    explicit PlayedFieldMonitor(const HologramOptions& options);

    bool isOn() const { return _monitor != nullptr; }

    /// What was submitted is not played any more: the next call of submit() counts.
    void forget() { _submitted = false; }
    /// Gives \a played, of \a array, on where it was not yet and the monitor waits for one.
    void submit(const haptics::FieldSequence& played,
                const std::vector<HapticObject>& objects,
                const haptics::TransducerArray& array);
    /// Whether something that was submitted has not been told, or something is still to be
    /// submitted.
    bool isPending() const { return isOn() && (_number > _told || !_submitted); }

    /// What the monitor found last; null before the first.
    std::shared_ptr<const haptics::FieldMonitor::Result> latest() const;
    /// The same where it was not told yet, else null.
    std::shared_ptr<const haptics::FieldMonitor::Result> takeNew();

private:
    const HologramOptions& _options;
    std::unique_ptr<haptics::FieldMonitor> _monitor; // null: not asked for
    bool _submitted = false;                         // what is played was given to the monitor
    std::uint64_t _number = 0;                       // of the last field that was
    std::uint64_t _told = 0;                         // of the last one whose result was taken
};

} // namespace midair::bridge
