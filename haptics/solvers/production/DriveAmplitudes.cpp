#include "haptics/solvers/production/DriveAmplitudes.h"

#include "haptics/solvers/FieldFigures.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

void DriveAmplitudes::choose(FieldProblem& field, const Wish& wish, float full)
{
    _wish = wish;
    const bool absolute = wish.level_Pa > 0.0f;
    float share = wish.loudness;
    if (absolute && full > 0.0f) share = std::min(share, wish.level_Pa / full);
    if (wish.phaseOnly && !absolute)
        share = playableAmplitude(field.drive().amplitudeLevels, share);
    _full = wish.phaseOnly && !absolute && share == 1.0f;
    if (_full) return;
    _gain = std::clamp(share, 0.0f, 1.0f);
    if (!wish.phaseOnly)
    {
        double power = 0.0;
        for (int i = 0; i < field.m(); ++i)
            power += std::norm(field.z.at(static_cast<std::size_t>(i)));
        const auto rms = static_cast<float>(std::sqrt(power / field.m()));
        _gain = rms > 0.0f ? share / rms : 0.0f;
    }
    set(field);
}

// Sets the playable amplitudes nearest to _gain: phase-only, an even mix of the two levels around
// it; else for each transducer the level nearest to _gain |z_i|. What is asked for in Pa begins
// with one transducer, however little it is.
void DriveAmplitudes::set(const FieldProblem& field)
{
    const std::vector<float>& levels = field.drive().amplitudeLevels;
    if (_wish.phaseOnly)
        mixAmplitudes(levels, _gain, field.m(), _amplitudes.data());
    else
    {
        for (std::size_t i = 0; i < static_cast<std::size_t>(field.m()); ++i)
            _amplitudes[i] = std::clamp(_gain * std::abs(field.z.at(i)), 0.0f, 1.0f);
        roundAmplitudes(levels,
                        field.m(),
                        _amplitudes.data(),
                        _wish.level_Pa > 0.0f ? kCoarseTarget : kCoarseSum);
    }
    if (!(_wish.level_Pa > 0.0f) || !(_gain > 0.0f) || rms(field) > 0.0f) return;
    const auto least = std::upper_bound(levels.begin(), levels.end(), 0.0f);
    const auto first = static_cast<std::size_t>(evenOrder(field.m()).front());
    _amplitudes[first] = least == levels.end() ? _gain : *least;
}

// The level between two of the device's is mixed of both, so one transducer's step between them is
// the least that the sum of all amplitudes can change by.
float DriveAmplitudes::leastChange(const FieldProblem& field) const
{
    const std::vector<float>& levels = field.drive().amplitudeLevels;
    const float mean = rms(field);
    const auto above = std::lower_bound(levels.begin(), levels.end(), mean);
    if (above == levels.end() || !(mean > 0.0f)) return 0.0f;
    const float below = above == levels.begin() ? 0.0f : *(above - 1);
    return (*above - below) / (static_cast<float>(field.m()) * mean);
}

bool DriveAmplitudes::scale(const FieldProblem& field, float ratio)
{
    if (!(ratio > 0.0f) || !std::isfinite(ratio) ||
        std::fabs(ratio - 1.0f) <= 0.5f * leastChange(field) || (isFull() && ratio > 1.0f))
        return false;
    _gain = _wish.phaseOnly ? std::min(_gain * ratio, 1.0f) : _gain * ratio;
    set(field);
    return true;
}

float DriveAmplitudes::rms(const FieldProblem& field) const
{
    if (_full) return 1.0f;
    double power = 0.0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(field.m()); ++i)
        power += static_cast<double>(_amplitudes[i]) * static_cast<double>(_amplitudes[i]);
    return static_cast<float>(std::sqrt(power / field.m()));
}

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
