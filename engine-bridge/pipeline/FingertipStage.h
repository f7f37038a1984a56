#pragma once

#include "engine-bridge/pipeline/PipelineStage.h"
#include "haptics/probe/FingertipForce.h"

#include <Eigen/Core>

#include <optional>
#include <vector>

namespace midair::bridge
{

/// Finds the force on a fingertip where it is strongest: at a few points of each field, at all of
/// one that rests, while nothing makes the next one, and for foci ten times a second.
class FingertipStage final : public PipelineStage
{
public:
    /// All arguments must outlive it. \a refiner and \a louder come first.
    FingertipStage(const PipelineContext& context,
                   const PipelineStage& refiner,
                   const PipelineStage& louder) :
        _context(context),
        _refiner(refiner),
        _louder(louder)
    {
    }

    RestStep attend(bool isPlaying) override;
    std::optional<double> rest_s(bool isPlaying) const override;
    void end() override { _search.end(); }
    void report(HologramResult& result, bool isOtherField) override;

private:
    bool hasTurn(bool isPlaying) const;
    bool isKnown(const HologramResult& result) const;
    void know(const haptics::FingertipForce& force);

    const PipelineContext& _context;
    const PipelineStage& _refiner;
    const PipelineStage& _louder;
    haptics::FingertipSearch _search;
    std::vector<Eigen::VectorXcf> _fields; // those that are searched
    haptics::FingertipForce _known;        // the most that was found in them
    double _ofFociUntil_s = 0.0;           // steady clock; until then it serves other foci; 0: no
};

} // namespace midair::bridge
