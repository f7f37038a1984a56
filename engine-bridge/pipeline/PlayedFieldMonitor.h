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

/// Passes played fields to a haptics::FieldMonitor, which certifies them and measures their surface
/// in another thread, if HologramOptions::monitorInterval is over 0.
class PlayedFieldMonitor
{
public:
    /// \a options must outlive the monitor.
    explicit PlayedFieldMonitor(const HologramOptions& options);

    /// To be called after the options have changed: begins anew if they change the monitor.
    void optionsChanged();

    bool isOn() const { return _monitor != nullptr; }

    /// To be called when another field is played, so that the next submit() passes it on.
    void forget() { _submitted = false; }
    /// Passes \a played on if that wasn't done since forget() and the monitor is idle. \a objects
    /// are those that \a played is for.
    void submit(const haptics::FieldSequence& played,
                const std::vector<HapticObject>& objects,
                const haptics::TransducerArray& array);
    /// Returns true if a result of a submitted field is outstanding or the field that is played is
    /// still to be submitted.
    bool isPending() const { return isOn() && (_number > _told || !_submitted); }

    /// The newest result; null before the first.
    std::shared_ptr<const haptics::FieldMonitor::Result> latest() const;
    /// The newest result if takeNew() has not returned it before, else null.
    std::shared_ptr<const haptics::FieldMonitor::Result> takeNew();

private:
    const HologramOptions& _options;
    double _interval_s = 0.0;                        // of _monitor
    double _lambda = 0.0;                            // of _monitor
    std::unique_ptr<haptics::FieldMonitor> _monitor; // null: disabled
    bool _submitted = false;                         // the monitor was given the current field
    std::uint64_t _number = 0;                       // number of the last field submitted
    std::uint64_t _told = 0;                         // number of the last result taken
};

} // namespace midair::bridge
