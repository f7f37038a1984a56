#include "haptics/sequence/EvenedCycle.h"

#include "haptics/sequence/FieldOrder.h"

namespace midair::haptics
{

namespace
{

CycleEqualizerOptions withPasses(int passes)
{
    CycleEqualizerOptions options;
    options.passes = passes;
    return options;
}

} // namespace

EvenedCycle::EvenedCycle(int passes, int steps, const SolverOptions& solver) :
    _equalizer(withPasses(passes), solver),
    _passes(passes),
    _steps(steps)
{
}

bool EvenedCycle::begin(const FieldSequence& cycle,
                        const ControlPoints& places,
                        const TransducerArray& array,
                        const Medium& medium)
{
    end();
    const auto stride = static_cast<std::size_t>(_steps + 1);
    if (_passes == 0 || cycle.fields.size() % stride != 0) return false;
    for (const ControlPoints& part : cycle.parts)
        if (part.size() > 0 && part.absolute) return false;
    std::vector<Eigen::VectorXcf> fields;
    for (std::size_t k = 0; k < cycle.fields.size(); k += stride)
        fields.push_back(cycle.fields[k]);
    // Steps between them leave next to nothing that rings.
    const double step_s = _steps == 0 ? 1.0 / cycle.modulation.fieldRate_Hz : 0.0;
    if (!_equalizer.begin(places, array, medium, std::move(fields), step_s)) return false;
    _cycle = cycle;
    _drive = array.drive;
    _ringing_s = array.ringing_s;
    _handedOut = 0.0;
    _seen = 0;
    return true;
}

std::optional<FieldSequence> EvenedCycle::step()
{
    if (!hasWork()) return std::nullopt;
    _equalizer.step();
    const double now = _equalizer.variation();
    if (_equalizer.passes() == 0) _handedOut = now; // that of the given cycle, once it is known
    if (_equalizer.passes() == _seen && hasWork()) return std::nullopt;
    _seen = _equalizer.passes();
    if (_seen == 0 || _equalizer.gain() < kLeastGain) return std::nullopt;
    if (now >= (hasWork() ? kWorthIt : 1.0) * _handedOut) return std::nullopt;
    _handedOut = now;
    return made();
}

FieldSequence EvenedCycle::made() const
{
    FieldSequence cycle = _cycle;
    // Not aligned anew: that would gain 5 % of driveChange at most, and turn fields that play.
    cycle.fields = smoothedFields(_equalizer.fields(), _steps, _drive);
    cycle.evened = true;
    rateSteps(cycle);
    rateRinging(cycle, _ringing_s);
    return cycle;
}

} // namespace midair::haptics
