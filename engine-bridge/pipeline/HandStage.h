#pragma once

#include "engine-bridge/hands/HandsAndObstacles.h"
#include "engine-bridge/pipeline/PipelineStage.h"

namespace midair::bridge
{

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
