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
    points.wavelength_m = _options.wavelength_m();
    points.motionTolerance_m = _options.motionTolerance * points.wavelength_m;
    points.maxPoints = _options.maxPoints;
    points.sets = _options.cycle;
    points.loudness = _options.solverOptions.loudness;
    return points;
}

haptics::ComposerOptions HologramPipeline::lineOptions() const
{
    haptics::ComposerOptions composer = composerOptions(_options);
    composer.line = _line;
    return composer;
}

void HologramPipeline::reconfigure(HologramOptions options)
{
    _changed = true;
    for (const base::Message& note : options.notes)
        _messages.say(note);
    if (isStricter(options)) silence();
    try
    {
        useOptions(std::move(options));
        _invalid.clear();
    }
    catch (...)
    {
        _invalid = base::whatWasThrown();
        _refiner->end();
        silence();
    }
}

void HologramPipeline::useOptions(HologramOptions options)
{
    options.array = _options.array;
    options.deviceUri = _options.deviceUri;
    options.deviceFactory = _options.deviceFactory;
    options.owner = _options.owner;
    options.solverOptions.stop = _options.solverOptions.stop;
    std::string error;
    if (!options.isValid(&error)) throw base::InputError(error);
    fillIn(options);
    if (!options.solverOptions.pool && std::min(options.solverOptions.threads, base::coreCount()) ==
                                           _options.solverOptions.threads)
        options.solverOptions.pool = _options.solverOptions.pool;
    keepToLimits(options, _messages);
    if (!options.solverFactory(options.solver, options.solverOptions))
        throw base::InputError("no solver \"" + options.solver + "\"");

    const bool otherSolver = options.solver != _options.solver;
    _options = std::move(options);
    setEars();
    setCaps();
    useParts(otherSolver);
}

// Gives the options to all that was made of the last ones.
void HologramPipeline::useParts(bool otherSolver)
{
    _assembler->setOptions(_options.array, assemblerOptions());
    _composer->setOptions(lineOptions(), otherSolver);
    _refiner = std::make_unique<RestRefiner>(_options, *_assembler, *_composer, _around, _messages);
    _refiner->setStop(_options.solverOptions.stop);
    _monitor->optionsChanged();
    makeContacts();
}

bool HologramPipeline::isOpenedNow()
{
    if (!_output->tryAgain()) return false;
    useAbility();
    _array = std::make_shared<haptics::TransducerArray>(_options.array);
    useParts(false);
    _changed = true;
    return true;
}

} // namespace midair::bridge
