#pragma once

#include "engine-bridge/hands/Obstacles.h"
#include "engine-bridge/pipeline/HologramOptions.h"
#include "engine-bridge/pipeline/HologramResult.h"
#include "engine-bridge/pipeline/PointAssembler.h"
#include "engine-bridge/pipeline/SceneReflectors.h"
#include "engine-bridge/playing/EarBound.h"
#include "haptics/base/text/MessageLog.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace midair::bridge
{

/// State shared by a pipeline and its stages.
struct PipelineContext
{
    /// Fills in and limits \a given; throws base::InputError if it is not valid.
    explicit PipelineContext(HologramOptions given);

    /// Returns a pointer for results; copies \a array unless it is this one's, because its owner's
    /// next call may overwrite it.
    std::shared_ptr<const haptics::TransducerArray>
    kept(const haptics::TransducerArray& array) const;
    /// Sets what follows for the reflectors of \a snapshot. Returns false if none has moved beyond
    /// half the motion tolerance, as an image moves twice as far as its mirror.
    bool follow(const SceneSnapshot& snapshot);
    /// Sets the copies of the options' array, whose levels have changed.
    void copyArray();

    /// Its array is what fields are solved for: it has the reflectors that are corrected.
    HologramOptions options;
    const base::Clock& clock; ///< of the first options
    /// The options' array with all reflectors, as it sounds: for results, caps, ears and figures.
    std::shared_ptr<const haptics::TransducerArray> array;
    /// The same without the scene's reflectors, which may be gone before the next frame; null: it
    /// has none.
    std::shared_ptr<const haptics::TransducerArray> bare;
    SceneReflectors reflectors;
    std::vector<haptics::Reflector> ownReflectors; ///< of the array itself
    std::vector<haptics::FlatFace> faces;          ///< of the last follow()
    std::vector<haptics::ReflectingBody> bodies;   ///< likewise
    base::MessageLog messages;
    HologramCounters counters;
    UpdateRate updates;                         ///< of the snapshots that were solved
    std::shared_ptr<const HologramResult> last; ///< null: there is none yet
    double level_Pa = 0.0;           ///< of the last field of whole objects, without caps
    std::vector<std::string> paths;  ///< of the objects of the newest snapshot, for messages
    std::vector<bool> areSensations; ///< the same objects
};

/// Result of a stage's step while no snapshot comes.
struct RestStep
{
    std::optional<haptics::FieldSequence> field; ///< to be played from now on
    std::shared_ptr<HologramResult> result;      ///< to be finished and published; null: none
    bool isOtherField = false;                   ///< the stage plays another field than before
    bool isAll = false;                          ///< later stages and the device have to wait
};

/// Accompanies a field on its way to the array and while it is played: hands, ears, contacts, the
/// refinement of fields at rest, and measurements. The pipeline calls all stages at the same
/// points, in its list's order; a stage ignores those that don't concern it.
class PipelineStage
{
public:
    PipelineStage() = default;
    virtual ~PipelineStage() = default;
    PipelineStage(const PipelineStage&) = delete;
    PipelineStage& operator=(const PipelineStage&) = delete;

    /// The context's options have changed.
    virtual void setOptions() {}

    /// The reflectors of the context's arrays have moved.
    virtual void setReflectors() { setOptions(); }

    /// A snapshot has come. Returns true if the playing field fits it, as far as this stage knows.
    /// A stage may replace \a snapshot by one that it owns and keeps until the next call.
    virtual bool arrive(const SceneSnapshot*& /*snapshot*/) { return true; }

    /// The playing field is about to be replaced.
    virtual void replace() {}

    /// \a whole is the field of whole objects, without caps. Returns false if more may be played.
    virtual bool compose(const haptics::FieldSequence& /*whole*/) { return true; }

    /// Returns true if the playing field may continue when the solver finds nothing that moved.
    virtual bool mayPlayOn() const { return true; }

    /// Plays the last field of compose() in its own way and stores the figures in \a result.
    /// Returns false if the pipeline should play it.
    virtual bool takeOver(HologramResult& /*result*/) { return false; }

    /// \a result is finished, for \a snapshot and \a array, which is valid during this call.
    virtual void settle(const HologramResult& /*result*/,
                        const SceneSnapshot& /*snapshot*/,
                        const haptics::TransducerArray& /*array*/)
    {
    }

    /// No snapshot comes: performs the next pending step. \a isPlaying: the array plays the points
    /// of the context's last result.
    virtual RestStep attend(bool /*isPlaying*/) { return {}; }

    /// Time until attend() has work, s; none if later stages or the device decide. \a isPlaying:
    /// the array plays.
    virtual std::optional<double> rest_s(bool /*isPlaying*/) const { return std::nullopt; }

    /// The array falls silent because no field could be computed.
    virtual void end() {}

    /// Adds this stage's data to \a result, whose state is already set. \a isOtherField: its field
    /// may differ from the last one.
    virtual void report(HologramResult& /*result*/, bool /*isOtherField*/) {}
};

/// Measures the level at ears. With a limit, fields are lowered for the ears' present places; if
/// the playing field keeps the limit at new places, or there is no limit, moved ears need no new
/// field.
class EarStage final : public PipelineStage
{
public:
    explicit EarStage(const PipelineContext& context) : _context(context) { setOptions(); }

    /// \a keeps returns true if the playing field may continue with the ears' present places.
    void setKeeps(std::function<bool()> keeps) { _keeps = std::move(keeps); }

    void setOptions() override;
    bool arrive(const SceneSnapshot*& snapshot) override;
    bool mayPlayOn() const override { return !_isMoved; }
    void report(HologramResult& result, bool isOtherField) override;

    double limit_dB() const { return _watch.limit_dB(); } ///< 0: there is none; any thread
    /// Limit for the fields; null: none.
    const EarBound* bound() { return _watch.bound(); }
    haptics::ExposureFigures reading() const; ///< as of now; any thread
    /// See EarWatch::each(); any thread.
    std::vector<haptics::PlaceExposure> each() const { return _watch.each(_context.clock.now_s()); }

private:
    const PipelineContext& _context;
    EarWatch _watch;
    std::function<bool()> _keeps;
    bool _isMoved = false; // the newest snapshot moved the ears; the limit needs a new field
};

/// Hands and props of the snapshot being solved: selects points that are near enough, and computes
/// which transducers they shadow.
class HandStage final : public PipelineStage
{
public:
    explicit HandStage(const PipelineContext& context) : _context(context) {}

    bool arrive(const SceneSnapshot*& snapshot) override
    {
        return _around.unmoved(snapshot->around);
    }

    /// Sets the hands and props for the following calls.
    void begin(const HandsAndObstacles& around) { _around.begin(around); }
    /// See ReachAndShadow.
    std::uint64_t keepWithinReach(haptics::ControlPoints& points, Eigen::Matrix3Xd& skipped) const
    {
        return _around.keepWithinReach(points, skipped);
    }
    /// Returns the options' array as heard at \a points; the next call overwrites it.
    const haptics::TransducerArray& shadowed(const haptics::ControlPoints& points)
    {
        return _around.shadowed(points, _context.options.array, _context.options.wavelength_m());
    }

private:
    const PipelineContext& _context;
    ReachAndShadow _around;
};

} // namespace midair::bridge
