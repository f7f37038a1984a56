#pragma once

#include "engine-bridge/hands/Obstacles.h"
#include "engine-bridge/pipeline/HologramOptions.h"
#include "engine-bridge/pipeline/HologramResult.h"
#include "engine-bridge/pipeline/PointAssembler.h"
#include "engine-bridge/playing/EarBound.h"
#include "haptics/base/text/MessageLog.h"

#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace midair::bridge
{

/// What a pipeline and its stages have in common.
struct PipelineContext
{
    /// Fills in and limits \a given; throws base::InputError if they are not valid.
    explicit PipelineContext(HologramOptions given);

    /// Returns the array as a result keeps it: \a array may be the caller's until its next call.
    std::shared_ptr<const haptics::TransducerArray>
    kept(const haptics::TransducerArray& array) const;

    HologramOptions options;
    const base::Clock& clock;                              ///< that of the first options
    std::shared_ptr<const haptics::TransducerArray> array; ///< that of options, for the results
    base::MessageLog messages;
    HologramCounters counters;
    std::shared_ptr<const HologramResult> last; ///< null: there is none yet
};

/// What a stage has made while no snapshot came.
struct RestStep
{
    std::optional<haptics::FieldSequence> field; ///< is to be played from now on
    std::shared_ptr<HologramResult> result;      ///< is to be finished and published; null: nothing
    bool isOtherField = false;                   ///< the stage plays another field than before
    bool isAll = false;                          ///< later stages and the device have to wait
};

/// What accompanies a field on its way to the array and while it is played: the hands, the ears,
/// contacts, what refines a field at rest, and what measures it. The pipeline calls all of them at
/// the same moments, in the order that it lists them in; a stage does nothing at those that don't
/// concern it.
class PipelineStage
{
public:
    PipelineStage() = default;
    virtual ~PipelineStage() = default;
    PipelineStage(const PipelineStage&) = delete;
    PipelineStage& operator=(const PipelineStage&) = delete;

    /// The context's options are others than before.
    virtual void setOptions() {}

    /// A snapshot has come. Returns true if what is played fits it, as far as this stage knows. A
    /// stage may put a snapshot of its own, which it keeps until the next call, in the place of
    /// \a snapshot.
    virtual bool arrive(const SceneSnapshot*& /*snapshot*/) { return true; }

    /// What is played is going to be replaced.
    virtual void replace() {}

    /// \a whole is what is to be played of whole objects, without caps. Returns false if more may
    /// be played than that.
    virtual bool compose(const haptics::FieldSequence& /*whole*/) { return true; }

    /// Returns true if what is played may go on where the solver finds nothing that moved.
    virtual bool mayPlayOn() const { return true; }

    /// Plays what compose() was given last in its own way, with the figures in \a result. Returns
    /// false if the pipeline should play it.
    virtual bool takeOver(HologramResult& /*result*/) { return false; }

    /// \a result is finished, for \a snapshot and \a array, which is valid during this call.
    virtual void settle(const HologramResult& /*result*/,
                        const SceneSnapshot& /*snapshot*/,
                        const haptics::TransducerArray& /*array*/)
    {
    }

    /// No snapshot comes: makes the next step of what is left to do. \a isPlaying: the array plays
    /// the points of the context's last result.
    virtual RestStep attend(bool /*isPlaying*/) { return {}; }

    /// The time until attend() has something to do, s; nothing if the stages that follow, or the
    /// device, decide that. \a isPlaying: the array plays.
    virtual std::optional<double> rest_s(bool /*isPlaying*/) const { return std::nullopt; }

    /// The array falls silent since no field could be computed.
    virtual void end() {}

    /// Adds to \a result what this stage knows; its state is there already. \a isOtherField: its
    /// field may be another than the last one.
    virtual void report(HologramResult& /*result*/, bool /*isOtherField*/) {}
};

/// Listens to what is played. With a limit, a field is held down for where the ears are now; where
/// what is played keeps to it there as well, and without one, they just hear another one when they
/// move.
class EarStage final : public PipelineStage
{
public:
    explicit EarStage(const PipelineContext& context) : _context(context) { setOptions(); }

    /// \a keeps returns true if what is played may go on where the ears are now.
    void setKeeps(std::function<bool()> keeps) { _keeps = std::move(keeps); }

    void setOptions() override;
    bool arrive(const SceneSnapshot*& snapshot) override;
    bool mayPlayOn() const override { return !_isMoved; }
    void report(HologramResult& result, bool isOtherField) override;

    double limit_dB() const { return _watch.limit_dB(); } ///< 0: there is none; any thread
    /// The limit for the fields; null: there is none.
    const EarBound* bound() { return _watch.bound(); }
    haptics::ExposureFigures reading() const; ///< as of now; any thread
    /// As EarWatch::each(), as of now; any thread.
    std::vector<haptics::PlaceExposure> each() const { return _watch.each(_context.clock.now_s()); }

private:
    const PipelineContext& _context;
    EarWatch _watch;
    std::function<bool()> _keeps;
    bool _isMoved = false; // by the newest snapshot, to where the limit asks for another field
};

/// The hands and props of the snapshot that is solved for: which points are near enough, and which
/// transducers they shadow.
class HandStage final : public PipelineStage
{
public:
    explicit HandStage(const PipelineContext& context) : _context(context) {}

    bool arrive(const SceneSnapshot*& snapshot) override
    {
        return _around.unmoved(snapshot->around);
    }

    /// Sets the hands and props for the calls that follow.
    void begin(const HandsAndObstacles& around) { _around.begin(around); }
    /// See ReachAndShadow.
    std::uint64_t keepWithinReach(haptics::ControlPoints& points, Eigen::Matrix3Xd& skipped) const
    {
        return _around.keepWithinReach(points, skipped);
    }
    /// The options' array as \a points hear it; valid until the next call.
    const haptics::TransducerArray& shadowed(const haptics::ControlPoints& points)
    {
        return _around.shadowed(points, _context.options.array, _context.options.wavelength_m());
    }

private:
    const PipelineContext& _context;
    ReachAndShadow _around;
};

} // namespace midair::bridge
