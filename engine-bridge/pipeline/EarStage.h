#pragma once

#include "engine-bridge/pipeline/PipelineStage.h"
#include "engine-bridge/playing/EarWatch.h"

namespace midair::bridge
{

/// Listens to what is played. With a limit, a field is held down for where the ears are now; else
/// they just hear another one when they move.
class EarStage final : public PipelineStage
{
public:
    explicit EarStage(const PipelineContext& context) : _context(context) { setOptions(); }

    void setOptions() override;
    bool arrive(const SceneSnapshot*& snapshot) override;
    bool mayPlayOn() const override { return !_isMoved; }
    void report(HologramResult& result, bool isOtherField) override;

    double limit_dB() const { return _watch.limit_dB(); } ///< 0: there is none; any thread
    /// The limit for the fields; null: there is none.
    const EarBound* bound() { return _watch.bound(); }
    haptics::ExposureFigures reading() const; ///< as of now; any thread

private:
    const PipelineContext& _context;
    EarWatch _watch;
    bool _isMoved = false; // by the newest snapshot, where a limit holds
};

} // namespace midair::bridge
