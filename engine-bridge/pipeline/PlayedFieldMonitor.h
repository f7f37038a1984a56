#pragma once

#include "engine-bridge/pipeline/PipelineStage.h"
#include "engine-bridge/pipeline/RestRefiner.h"
#include "haptics/sequence/FieldMonitor.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace midair::bridge
{

/// Passes played fields to a haptics::FieldMonitor, which certifies them and measures their surface
/// in another thread, if HologramOptions::monitorInterval is over 0. Rates fields at rest by what
/// the accuracy of their reflectors lets one expect.
class PlayedFieldMonitor final : public PipelineStage
{
public:
    /// All arguments must outlive it. \a refiner has the snapshot of the playing field.
    PlayedFieldMonitor(PipelineContext& context, const RestRefiner& refiner);

    /// Starts again if the options change the monitor.
    void setOptions() override;
    void setReflectors() override;
    void replace() override;
    void settle(const HologramResult& result,
                const SceneSnapshot& snapshot,
                const haptics::TransducerArray& array) override;
    RestStep attend(bool isPlaying) override;
    std::optional<double> rest_s(bool isPlaying) const override;
    void report(HologramResult& result, bool isOtherField) override;

private:
    /// Passes \a played on unless that was done since replace() or the monitor is busy. \a objects
    /// belong to \a played.
    void submit(const haptics::FieldSequence& played,
                const std::vector<HapticObject>& objects,
                const std::shared_ptr<const haptics::TransducerArray>& array);
    bool areReflectorsUnrated() const;
    RestStep rateReflectors();

    PipelineContext& _context;
    const RestRefiner& _refiner;
    double _interval_s = 0.0;                        // of _monitor
    double _lambda = 0.0;                            // of _monitor
    std::unique_ptr<haptics::FieldMonitor> _monitor; // null: disabled
    bool _isSubmitted = false;                       // the monitor has the current field
    std::uint64_t _number = 0;                       // number of the last field submitted
    std::uint64_t _told = 0;                         // number of the last result taken
    double _since_s = 0.0;               // when the current field came, of the context's clock
    std::optional<double> _reflectorRms; // of the current field; none: not rated
};

} // namespace midair::bridge
