#pragma once

#include "engine-bridge/pipeline/CappedOutput.h"
#include "engine-bridge/pipeline/LouderStage.h"
#include "engine-bridge/pipeline/PipelineStage.h"
#include "engine-bridge/pipeline/RestRefiner.h"
#include "haptics/base/threads/LatestWorker.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/scattering/RestScattering.h"
#include "haptics/sequence/SequenceComposer.h"
#include "haptics/solvers/production/LouderPhases.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Corrects a held field beside rigid things, while its scene rests and nothing is left to refine,
/// for their full waves, of which its rows know images at most (haptics::RestScattering). Another
/// thread solves for seconds; the field then walks to the corrected one. Its figures and its cap
/// know the full waves from then on. Fields that are evened out, in turn, or of outlines stay.
class ScatteringStage final : public PipelineStage
{
public:
    /// All arguments must outlive it. \a refiner and \a louder come first.
    ScatteringStage(PipelineContext& context,
                    const haptics::SequenceComposer& composer,
                    const CappedOutput& output,
                    HandStage& hands,
                    const RestRefiner& refiner,
                    const LouderStage& louder);
    /// Stops the other thread, which takes up to a second for large things.
    ~ScatteringStage() override { _stop.request(); }

    void setOptions() override;
    void replace() override;
    void settle(const HologramResult& result,
                const SceneSnapshot& snapshot,
                const haptics::TransducerArray& array) override;
    RestStep attend(bool isPlaying) override;
    std::optional<double> rest_s(bool isPlaying) const override;
    void end() override;

private:
    enum class Work
    {
        NONE,
        BEGIN,
        SOLVE,
        WALK
    };
    struct Request
    {
        std::uint64_t frame = 0;
        haptics::FieldBesideThings field;
    };
    struct Answer
    {
        std::uint64_t frame = 0;
        haptics::FieldForThings field;
    };
    using Worker = base::LatestWorker<Request, Answer>;

    static std::unique_ptr<Worker> makeWorker();
    bool hasTurn(bool isPlaying) const;
    haptics::RigidThings things() const;
    bool canBeCorrected(const HologramResult& result) const;
    void begin();
    void take(const Answer& answer);
    double rate(const Eigen::VectorXcf& q, haptics::FieldSequence& next) const;
    std::optional<haptics::FieldSequence> walk();
    void stop();
    void tell(const std::string& text);

    PipelineContext& _context;
    const haptics::SequenceComposer& _composer;
    const CappedOutput& _output;
    HandStage& _hands;
    const RestRefiner& _refiner;
    const LouderStage& _louder;
    Work _work = Work::NONE;
    double _due_s = 0.0;      // on the context's clock: nothing to do before
    std::uint64_t _asked = 0; // number of the last request
    haptics::FieldSequence _corrected;
    haptics::PhaseWalk _walk;
    double _image_Pa = 0.0;          // level of the playing field on the walk, with images alone
    bool _isOwn = false;             // the next replace() is this stage's
    base::StopSource _stop;          // of the last request
    std::unique_ptr<Worker> _worker; // null: nothing was asked yet
};

} // namespace midair::bridge
