#include "haptics/solvers/production/CorrectedDrive.h"

#include "haptics/solvers/FieldFigures.h"

#include <algorithm>

namespace midair::haptics
{

void CorrectedDrive::begin(const FieldProblem& field)
{
    const auto m = static_cast<std::size_t>(field.G.paddedTransducers());
    _phases.reserve(m);
    amplitudes.reserve(field);
    copy(field.q, _phases, m);
}

// Sets q in one block: with an effort, rounded but for the transducers to be shaped.
void CorrectedDrive::put(FieldProblem& field, int block, const ShapedRounding::Effort* effort)
{
    const int lane = field.G.offset(block), width = field.G.width(block);
    const float *fromRe = _phases.re.data() + lane, *fromIm = _phases.im.data() + lane;
    float *re = field.q.re.data() + lane, *im = field.q.im.data() + lane;
    const int rounded = effort ? ShapedRounding::first(field, block, *effort) : 0;
    kernels::quantisePhase(rounded, field.drive().phaseLevels, fromRe, fromIm, re, im);
    std::copy(fromRe + rounded, fromRe + width, re + rounded);
    std::copy(fromIm + rounded, fromIm + width, im + rounded);
    if (amplitudes.data()) kernels::scaleBy(width, amplitudes.data() + lane, re, im);
}

void CorrectedDrive::advance(FieldProblem& field,
                             const GaussNewtonStep* step,
                             const ShapedRounding::Effort* effort,
                             const QuietPoints* quiet)
{
    const bool continuous = field.drive().phaseLevels == 0;
    if (continuous) effort = nullptr;
    field.eachBlock(
        [&](int, int block)
        {
            if (step) step->turn(field, block, _phases);
            put(field, block, effort);
            field.forwardBlock(block, field.q);
        });
    field.sumPartials(field.p);
    field.phasesOf(field.p);
    if (effort && effort->share > 0.0f)
        _shaping.shape(field, *quiet, amplitudes.data(), fittedLevel(field), *effort);
    if (effort || continuous) field.clearPadding(field.q);
}

} // namespace midair::haptics
