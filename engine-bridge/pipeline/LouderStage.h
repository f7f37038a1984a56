#pragma once

#include "engine-bridge/pipeline/EveningWalk.h"
#include "engine-bridge/pipeline/PipelineStage.h"
#include "engine-bridge/pipeline/RestRefiner.h"
#include "haptics/sequence/SequenceComposer.h"
#include "haptics/solvers/production/LouderPhases.h"

#include <memory>
#include <optional>

namespace midair::bridge
{

/// Makes a held field louder while its scene rests and nothing is left to refine: it looks for
/// better phases of the points, and walks the playing field there in steps too small to be felt or
/// heard (haptics::PhaseWalk). Later updates go on from the louder field. For ratios of pressures,
/// and for targets in Pa that the array does not reach.
class LouderStage final : public PipelineStage
{
public:
    /// Least gain of loudness that is walked to.
    static constexpr double kLeastGain = 1.005;

    /// All arguments must outlive it. \a refiner comes first.
    LouderStage(PipelineContext& context,
                haptics::SequenceComposer& composer,
                HandStage& hands,
                const RestRefiner& refiner);

    void setOptions() override;
    void replace() override;
    void settle(const HologramResult& result,
                const SceneSnapshot& snapshot,
                const haptics::TransducerArray& array) override;
    /// Makes the next step of the search, or the next field of the walk. Throws base::Stopped if a
    /// stop was requested; the step then has to be repeated.
    RestStep attend(bool isPlaying) override;
    std::optional<double> rest_s(bool isPlaying) const override;
    void end() override { _work = Work::NONE; }

private:
    enum class Work
    {
        NONE,
        BEGIN,
        SEARCH,
        WALK
    };

    bool hasTurn(bool isPlaying) const;
    bool canBeLouder(const HologramResult& result) const;
    void begin();
    void search();
    std::optional<haptics::FieldSequence> walk();

    PipelineContext& _context;
    haptics::SequenceComposer& _composer;
    HandStage& _hands;
    const RestRefiner& _refiner;
    std::unique_ptr<haptics::LouderPhases> _phases;
    haptics::PhaseWalk _walk;
    Work _work = Work::NONE;
    double _due_s = 0.0; // on the context's clock: nothing to do before
    double _rms = 0.0;   // of the field at the start of the walk
    bool _isOwn = false; // the next replace() is this stage's
};

} // namespace midair::bridge
