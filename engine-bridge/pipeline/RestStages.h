#pragma once

#include "engine-bridge/pipeline/LouderStage.h"
#include "engine-bridge/pipeline/RestRefiner.h"
#include "engine-bridge/pipeline/ScatteringStage.h"

namespace midair::bridge
{

/// What improves the field of a scene at rest, in this order: each has its turn once the ones
/// before have nothing left to do.
struct RestStages
{
    /// All arguments must outlive it.
    RestStages(PipelineContext& context,
               PointAssembler& assembler,
               haptics::SequenceComposer& composer,
               const CappedOutput& output,
               HandStage& hands) :
        refiner(context, assembler, composer, hands),
        louder(context, composer, hands, refiner),
        scattering(context, composer, output, hands, refiner, louder)
    {
    }

    void setOptions()
    {
        refiner.setOptions();
        louder.setOptions();
        scattering.setOptions();
    }
    /// Drops the remaining work.
    void end()
    {
        refiner.end();
        louder.end();
        scattering.end();
    }

    RestRefiner refiner;
    LouderStage louder;
    ScatteringStage scattering;
};

} // namespace midair::bridge
