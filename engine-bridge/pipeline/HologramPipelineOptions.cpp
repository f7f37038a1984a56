// How a HologramPipeline takes other options while its device stays open.
#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/base/InputError.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/threads/ThreadPool.h"

#include <algorithm>
#include <utility>

namespace midair::bridge
{

PointAssembler::Options HologramPipeline::assemblerOptions() const
{
    PointAssembler::Options points;
    points.wavelength_m = _context.options.wavelength_m();
    points.motionTolerance_m = _context.options.motionTolerance * points.wavelength_m;
    points.maxPoints = _context.options.maxPoints;
    points.sets = _context.options.cycle;
    points.loudness = _context.options.solverOptions.loudness;
    return points;
}

haptics::ComposerOptions HologramPipeline::lineOptions() const
{
    haptics::ComposerOptions composer = composerOptions(_context.options);
    composer.line = _output.line();
    return composer;
}

void HologramPipeline::setStop(const base::StopToken& stop)
{
    _context.options.solverOptions.stop = stop;
    _assembler.setStop(stop);
    _composer.setStop(stop);
    _refiner.setOptions();
}

void HologramPipeline::reconfigure(HologramOptions options)
{
    _isChanged = true;
    for (const base::Message& note : options.notes)
        _context.messages.say(note);
    if (isStricter(options)) silence();
    try
    {
        useOptions(std::move(options));
        _invalid.clear();
    }
    catch (...)
    {
        _invalid = base::whatWasThrown();
        _refiner.end();
        silence();
    }
}

void HologramPipeline::useOptions(HologramOptions options)
{
    options.array = _context.options.array;
    options.deviceUri = _context.options.deviceUri;
    options.deviceFactory = _context.options.deviceFactory;
    options.owner = _context.options.owner;
    options.solverOptions.stop = _context.options.solverOptions.stop;
    std::string error;
    if (!options.isValid(&error)) throw base::InputError(error);
    fillIn(options);
    if (!options.solverOptions.pool && std::min(options.solverOptions.threads, base::coreCount()) ==
                                           _context.options.solverOptions.threads)
        options.solverOptions.pool = _context.options.solverOptions.pool;
    keepToLimits(options, _context.messages);
    if (!options.solverFactory(options.solver, options.solverOptions))
        throw base::InputError("no solver \"" + options.solver + "\"");

    const bool otherSolver = options.solver != _context.options.solver;
    _context.options = std::move(options);
    _output.setCaps();
    useParts(otherSolver);
}

// Gives the options to all that was made of the last ones.
void HologramPipeline::useParts(bool otherSolver)
{
    _assembler.setOptions(_context.options.array, assemblerOptions());
    _composer.setOptions(lineOptions(), otherSolver);
    for (PipelineStage* stage : _stages)
        stage->setOptions();
}

bool HologramPipeline::isOpenedNow()
{
    if (!device().tryAgain()) return false;
    _output.useAbility();
    useParts(false);
    _isChanged = true;
    return true;
}

} // namespace midair::bridge
